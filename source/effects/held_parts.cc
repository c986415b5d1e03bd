#include <emmy/base/text.h>
#include <emmy/effects/held_parts.h>

namespace emmy
{
  template <int dim>
  HeldParts<dim>::HeldParts(const BoundaryConditions<dim> &boundary_conditions)
    : boundary_conditions(boundary_conditions)
    , sums(boundary_conditions.held_parts().size())
    , n_held(sums.size(), 1)
    , is_told(sums.size())
  {}

  template <int dim>
  EffectCard
  HeldParts<dim>::card(const BoundaryConditions<dim> *boundary_conditions)
  {
    EffectCard card;
    card.name           = "held parts";
    card.setting        = "Boundary conditions/Held parts";
    card.enters         = "velocity from momentum, Newton: given values";
    card.ledger_columns = {"reaction_work"};
    card.is_present     = boundary_conditions;
    if (!boundary_conditions)
      return card;
    for (const HeldPart<dim> &part : boundary_conditions->held_parts())
      for (const std::string &column :
           ReactionSum<dim>::columns_of("held_" + part.name))
        card.ledger_columns.push_back(column);
    return card;
  }

  template <int dim>
  const GivenMotion<dim> *
  HeldParts<dim>::given_motion() const
  {
    return this;
  }

  template <int dim>
  std::string
  HeldParts<dim>::work_column() const
  {
    return "reaction_work";
  }

  template <int dim>
  template <class Function>
  void
  HeldParts<dim>::for_each_held(const ActiveGrid<dim> &active,
                                const Function        &function) const
  {
    const unsigned int none  = sums.size();
    unsigned int       entry = 0;
    for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
      {
        const auto &x = active.position(node);
        for (unsigned int c = 0; c < dim; ++c, ++entry)
          if (const auto part = boundary_conditions.part_that_holds(x, c);
              part != none)
            function(part, c, x, entry);
      }
  }

  template <int dim>
  void
  HeldParts<dim>::add_of_parts(
    const std::vector<dealii::Tensor<1, dim>> &of_part,
    const ActiveGrid<dim>                     &active,
    Vector                                    &vector) const
  {
    const auto first = vector.begin();
    for_each_held(active,
                  [&](const unsigned int part,
                      const unsigned int c,
                      const dealii::Point<dim> &,
                      const unsigned int entry) {
                    *(first + entry) += of_part[part][c];
                  });
  }

  template <int dim>
  void
  HeldParts<dim>::add_velocity(const ActiveGrid<dim> &active,
                               const double           time,
                               Vector                &velocity) const
  {
    std::vector<dealii::Tensor<1, dim>> of_part;
    for (const HeldPart<dim> &part : boundary_conditions.held_parts())
      of_part.push_back(part.velocity_at(time));
    add_of_parts(of_part, active, velocity);
  }

  template <int dim>
  void
  HeldParts<dim>::add_displacement(const ActiveGrid<dim> &active,
                                   const double           time,
                                   const double           time_step,
                                   Vector                &displacement) const
  {
    std::vector<dealii::Tensor<1, dim>> of_part;
    for (const HeldPart<dim> &part : boundary_conditions.held_parts())
      of_part.push_back(part.displacement_over(time, time_step));
    add_of_parts(of_part, active, displacement);
  }

  template <int dim>
  void
  HeldParts<dim>::see_reactions(const ActiveGrid<dim> &active,
                                const Vector          &force)
  {
    std::vector<unsigned int> n(sums.size(), 0);
    sums.assign(sums.size(), {});
    const auto first = force.begin();
    for_each_held(active,
                  [&](const unsigned int        part,
                      const unsigned int        c,
                      const dealii::Point<dim> &x,
                      const unsigned int        entry) {
                    ++n[part];
                    // that on the body is the residual
                    sums[part].add(x, c, -*(first + entry));
                  });
    dealii::Utilities::MPI::sum(n, active.communicator(), n_held);
  }

  template <int dim>
  std::vector<StepMeasure>
  HeldParts<dim>::measure(const PointArrays<dim> &,
                          const double,
                          const BackgroundGrid<dim> &grid)
  {
    std::vector<StepMeasure> result;
    for (unsigned int part = 0; part < sums.size(); ++part)
      sums[part].append_to(result,
                           "held_" +
                             boundary_conditions.held_parts()[part].name,
                           grid.communicator());
    return result;
  }

  template <int dim>
  std::string
  HeldParts<dim>::finding()
  {
    std::string result;
    for (unsigned int part = 0; part < sums.size(); ++part)
      if (n_held[part] == 0 && !is_told[part])
        {
          is_told[part] = true;
          result += (result.empty() ? "" : "; ") + std::string("held part <") +
                    boundary_conditions.held_parts()[part].name +
                    "> holds nothing: no body reaches a node in its Region";
        }
    return result;
  }

  template class HeldParts<2>;
  template class HeldParts<3>;
} // namespace emmy
