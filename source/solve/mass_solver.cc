#include <emmy/base/text.h>
#include <emmy/solve/mass_solver.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace emmy
{
  namespace
  {
    /** Which nodes this rank owns, and which it knows besides. Collective. */
    template <int dim>
    dealii::Utilities::MPI::Partitioner
    partition_of(const ActiveGrid<dim> &grid)
    {
      dealii::IndexSet own(grid.n_dofs() / dim), others(own.size());
      if (grid.n_owned_nodes() > 0)
        own.add_range(grid.first_dof(0) / dim,
                      grid.first_dof(0) / dim + grid.n_owned_nodes());
      for (unsigned int node = grid.n_owned_nodes();
           node < grid.n_local_nodes();
           ++node)
        others.add_index(grid.first_dof(node) / dim);
      return {own, others, grid.communicator()};
    }
  } // namespace

  template <int dim>
  MassSolver<dim>::MassSolver(const NodalMatrix<dim>    &mass,
                              const std::vector<double> &damping,
                              const Conditions           conditions)
    : mass(mass)
    , graph(mass.grid().graph())
    , conditions(conditions)
    , exchange(partition_of(mass.grid()))
  {
    find_diagonal(damping);
  }

  template <int dim>
  bool
  MassSolver<dim>::is_free(const unsigned int unknown) const
  {
    return conditions == Conditions::left_out || graph.is_free(unknown);
  }

  template <int dim>
  typename MassSolver<dim>::Values
  MassSolver<dim>::with_stride(const std::vector<double> &local)
  {
    Values result(stride * (local.size() / dim));
    for (unsigned int i = 0; i < local.size(); ++i)
      result[at(i)] = local[i];
    return result;
  }

  template <int dim>
  std::vector<double>
  MassSolver<dim>::without_stride(const Values &values)
  {
    std::vector<double> result(dim * (values.size() / stride));
    for (unsigned int i = 0; i < result.size(); ++i)
      result[i] = values[at(i)];
    return result;
  }

  template <int dim>
  void
  MassSolver<dim>::add_at_owners(Values &values) const
  {
    exchange.add(values.data(),
                 stride,
                 values.data() + stride * mass.grid().n_owned_nodes());
  }

  template <int dim>
  void
  MassSolver<dim>::tell_others(Values &values) const
  {
    exchange.update(values.data(),
                    stride,
                    values.data() + stride * mass.grid().n_owned_nodes());
  }

  template <int dim>
  void
  MassSolver<dim>::find_diagonal(const std::vector<double> &damping)
  {
    const bool has_followers = conditions == Conditions::worked_in &&
                               mass.grid().constraints().has_followers();
    Values diagonal(stride * graph.n_nodes());
    for (unsigned int node = 0; node < graph.n_nodes(); ++node)
      {
        const auto row = graph.row(node);
        if (row.n == 0)
          continue;
        for (unsigned int c = 0; c < dim; ++c)
          diagonal[at(unknown<dim>(node, c))] +=
            mass.diagonal(node) + damping[node];
        if (!has_followers)
          continue;
        // of sum w_i w_j M_ij what has the same root twice
        for (unsigned int c = 0; c < dim; ++c)
          {
            const unsigned int i = unknown<dim>(node, c);
            for (unsigned int k = 0; k < row.n; ++k)
              {
                const unsigned int j = unknown<dim>(row.nodes[k], c);
                if (is_free(i) && is_free(j))
                  continue;
                graph.for_each_root(
                  i, [&](const unsigned int root, const double w) {
                    graph.for_each_root(
                      j, [&](const unsigned int other, const double v) {
                        if (root == other)
                          diagonal[at(root)] += w * v * mass[row.first + k];
                      });
                  });
              }
          }
      }
    add_at_owners(diagonal);
    inverse.assign(diagonal.size(), 0.);
    for (unsigned int i = 0; i < dim * mass.grid().n_owned_nodes(); ++i)
      if (is_free(i) && diagonal[at(i)] > 0.)
        inverse[at(i)] = 1. / diagonal[at(i)];
  }

  template <int dim>
  void
  MassSolver<dim>::expand(Values &values) const
  {
    if (conditions == Conditions::left_out ||
        !mass.grid().constraints().has_followers())
      return;
    for (unsigned int i = 0; i < dim * graph.n_nodes(); ++i)
      if (!graph.is_free(i))
        {
          values[at(i)] = 0.;
          graph.for_each_root(i, [&](const unsigned int root, const double w) {
            values[at(i)] += w * values[at(root)];
          });
        }
  }

  template <int dim>
  void
  MassSolver<dim>::condense(Values &forces) const
  {
    if (conditions == Conditions::worked_in)
      for (unsigned int i = 0; i < dim * graph.n_nodes(); ++i)
        if (!graph.is_free(i))
          {
            graph.for_each_root(i,
                                [&](const unsigned int root, const double w) {
                                  forces[at(root)] += w * forces[at(i)];
                                });
            forces[at(i)] = 0.;
          }
    add_at_owners(forces);
  }

  template <int dim>
  typename MassSolver<dim>::Values
  MassSolver<dim>::residual(const Values &x, const Values &b) const
  {
    Values r(x.size());
    mass.multiply(x, r);
    for (double &entry : r)
      entry *= -1.;
    // each force once, where it is owned
    for (unsigned int i = 0; i < stride * mass.grid().n_owned_nodes(); ++i)
      r[i] += b[i];
    condense(r);
    return r;
  }

  template <int dim>
  std::pair<typename MassSolver<dim>::Components,
            typename MassSolver<dim>::Components>
  MassSolver<dim>::products(const Values &a,
                            const Values &b,
                            const Values &c) const
  {
    std::vector<double> sums(2 * dim, 0.);
    for (unsigned int i = 0; i < stride * mass.grid().n_owned_nodes();
         i += stride)
      for (unsigned int d = 0; d < dim; ++d)
        {
          sums[d] += a[i + d] * b[i + d];
          sums[dim + d] += a[i + d] * c[i + d];
        }
    dealii::Utilities::MPI::sum(sums, mass.grid().communicator(), sums);
    std::pair<Components, Components> result;
    std::copy_n(sums.begin(), dim, result.first.begin());
    std::copy_n(sums.begin() + dim, dim, result.second.begin());
    return result;
  }

  template <int dim>
  double
  MassSolver<dim>::total(const Components &components)
  {
    return std::accumulate(components.begin(), components.end(), 0.);
  }

  template <int dim>
  double
  MassSolver<dim>::norm(const Values &values) const
  {
    return std::sqrt(total(products(values, values, values).first));
  }

  template <int dim>
  unsigned int
  MassSolver<dim>::correct(Values            &x,
                           Values             r,
                           const double       goal,
                           const unsigned int most) const
  {
    Values     z(r.size()), p(r.size()), q(r.size());
    Components rz{};
    for (unsigned int iteration = 0;; ++iteration)
      {
        // with one sweep too many, and one sum over the ranks less each time
        mass.sweep(inverse, r, z);
        tell_others(z);
        const Components rz_before = rz;
        const auto [of_z, of_r]    = products(r, z, r);
        rz                         = of_z;
        if (std::sqrt(total(of_r)) <= goal)
          return iteration;
        if (iteration == most)
          return most + 1;
        Components beta{}, alpha{};
        for (unsigned int c = 0; c < dim; ++c)
          if (rz_before[c] > 0.)
            beta[c] = rz[c] / rz_before[c];
        for (unsigned int i = 0; i < p.size(); i += stride)
          for (unsigned int c = 0; c < dim; ++c)
            p[i + c] = z[i + c] + beta[c] * p[i + c];
        expand(p);
        mass.multiply(p, q);
        condense(q);
        const Components pq = products(p, q, q).first;
        for (unsigned int c = 0; c < dim; ++c)
          if (pq[c] > 0.)
            alpha[c] = rz[c] / pq[c];
        for (unsigned int i = 0; i < p.size(); i += stride)
          for (unsigned int c = 0; c < dim; ++c)
            {
              x[i + c] += alpha[c] * p[i + c];
              r[i + c] -= alpha[c] * q[i + c];
            }
      }
  }

  template <int dim>
  LinearResult
  MassSolver<dim>::solve(Vector &x, const Vector &b) const
  {
    constexpr unsigned int most_iterations = 200, most_refinements = 10;
    constexpr double       of_residual = 1e-10, round_off = 1e-16;

    const ActiveGrid<dim> &grid = mass.grid();
    LinearResult           result;
    const Values           right = with_stride(grid.to_local(b));
    Values                 found = with_stride(grid.to_local(x));
    Values                 r     = residual(found, right);
    double                 left  = norm(r);
    // walls that move bring momentum into a body at rest, where b is zero
    const double scale = std::max(b.l2_norm(), left);
    for (unsigned int i = 0; i < most_refinements && left > round_off * scale;
         ++i)
      {
        // from r on the last digits are those of the round-off of r
        const double goal   = std::max(of_residual * left, round_off * scale);
        Values       better = found, correction(found.size());
        const unsigned int n =
          correct(correction, r, goal, most_iterations - result.iterations);
        result.iterations = std::min(most_iterations, result.iterations + n);
        expand(correction);
        for (unsigned int k = 0; k < better.size(); ++k)
          better[k] += correction[k];
        Values       rest         = residual(better, right);
        const double norm_of_rest = norm(rest);
        if (!(norm_of_rest < 0.9 * left))
          break;
        found = std::move(better);
        r     = std::move(rest);
        left  = norm_of_rest;
        if (result.iterations == most_iterations)
          break;
      }
    // far above round-off, far below what a ledger would show
    const double size = b.l2_norm();
    if (!(left <= 1e-14 * (size > 0. ? size : scale)))
      {
        result.is_solved = false;
        result.problem   = "the residual of the point-to-grid map stays at " +
                         shortest(left / scale) + " of the momentum";
        return result;
      }
    x = grid.to_vector(without_stride(found));
    return result;
  }

  template class MassSolver<2>;
  template class MassSolver<3>;
} // namespace emmy
