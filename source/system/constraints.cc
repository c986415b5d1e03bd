#include <deal.II/lac/la_parallel_vector.h>

#include <emmy/base/dealii_version.h>
#include <emmy/system/constraints.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    using Exchange = dealii::LinearAlgebra::distributed::Vector<double>;
  }

  Constraints::Constraints()
  {
    lines.close();
  }

  Constraints::Constraints(
    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> partition)
    : partition(std::move(partition))
  {
    const dealii::IndexSet &owned = this->partition->locally_owned_range();
    dealii::IndexSet        known = owned;
    known.add_indices(this->partition->ghost_indices());
    reinit_constraints(lines, owned, known);
  }

  void
  Constraints::fix(const Dof dof)
  {
    lines.add_line(dof);
  }

  void
  Constraints::follow(const Dof dof, const Entries &entries)
  {
    lines.add_line(dof);
    lines.add_entries(dof, entries);
    if (!partition->in_local_range(dof))
      return;
    followers.push_back({partition->global_to_local(dof), {}});
    for (const auto &[root, weight] : entries)
      followers.back().roots.emplace_back(partition->global_to_local(root),
                                          weight);
  }

  void
  Constraints::close(const bool has_followers)
  {
    is_followed = has_followers;
    lines.close();
  }

  void
  Constraints::expand(Vector &vector) const
  {
    if (!is_followed)
      return;
    Exchange values(partition);
    std::copy(vector.begin(), vector.end(), values.begin());
    values.update_ghost_values();
    for (const Follower &follower : followers)
      {
        double sum = 0.;
        for (const auto &[root, weight] : follower.roots)
          sum += weight * values.local_element(root);
        vector.begin()[follower.dof] = sum;
      }
  }

  void
  Constraints::fold(Vector &vector) const
  {
    if (!is_followed)
      return;
    Exchange sums(partition);
    for (const Follower &follower : followers)
      {
        double &force = vector.begin()[follower.dof];
        for (const auto &[root, weight] : follower.roots)
          sums.local_element(root) += weight * force;
        force = 0.;
      }
    sums.compress(dealii::VectorOperation::add);
    auto sum = sums.begin();
    for (double &force : vector)
      force += *sum++;
  }

  void
  Constraints::condense(Vector &vector) const
  {
    fold(vector);
    // set_zero() ends with an exchange of what there is none of
    for (const auto &line : lines.get_lines())
      if (partition->in_local_range(line.index))
        vector.begin()[partition->global_to_local(line.index)] = 0.;
  }
} // namespace emmy
