#include <emmy/effects/reactions.h>

#include <algorithm>

namespace emmy
{
  ReactionParameters::ReactionParameters(const std::string &section)
    : Section(section)
  {
    add_parameter("Reactions",
                  are_present,
                  "Whether the ledger has the force and the moment about the "
                  "origin on each side in <Fixed> or <Roller>: "
                  "wall_x_min_force_x and so on, in N and N m, in the plane "
                  "per metre.");
  }

  template <int dim>
  std::vector<std::string>
  ReactionSum<dim>::columns_of(const std::string &beginning)
  {
    std::vector<std::string> columns;
    for (unsigned int d = 0; d < dim; ++d)
      columns.push_back(beginning + "_force_" + "xyz"[d]);
    for (unsigned int d = 3 - n_moments; d < 3; ++d)
      columns.push_back(beginning + "_moment_" + "xyz"[d]);
    return columns;
  }

  template <int dim>
  void
  ReactionSum<dim>::add(const dealii::Point<dim> &x,
                        const unsigned int        c,
                        const double              f)
  {
    values[c] += f;
    if (dim == 2)
      values[dim] += c == 0 ? -x[1] * f : x[0] * f;
    else // x cross f
      {
        values[dim + (c + 1) % 3] += x[(c + 2) % 3] * f;
        values[dim + (c + 2) % 3] -= x[(c + 1) % 3] * f;
      }
  }

  template <int dim>
  void
  ReactionSum<dim>::append_to(std::vector<StepMeasure> &measures,
                              const std::string        &beginning,
                              const MPI_Comm            communicator) const
  {
    std::vector<double> of_ranks(values.begin(), values.end());
    dealii::Utilities::MPI::sum(of_ranks, communicator, of_ranks);
    const auto columns = columns_of(beginning);
    for (unsigned int i = 0; i < of_ranks.size(); ++i)
      measures.push_back({columns[i], of_ranks[i]});
  }

  template <int dim>
  Reactions<dim>::Reactions(const BoundaryConditions<dim> &boundary_conditions)
    : boundary_conditions(boundary_conditions)
  {}

  template <int dim>
  std::string
  Reactions<dim>::beginning_of(const unsigned int side)
  {
    std::string name = side_names(dim)[side];
    std::replace(name.begin(), name.end(), '-', '_');
    return "wall_" + name;
  }

  template <int dim>
  EffectCard
  Reactions<dim>::card(const BoundaryConditions<dim> *boundary_conditions)
  {
    EffectCard card;
    card.name    = "reactions";
    card.setting = "Boundary conditions/Reactions = true";
    card.enters  = "accounts: a pass over the nodes on the sides";
    for (unsigned int side = 0; side < 2 * dim; ++side)
      if (!boundary_conditions ||
          boundary_conditions->fixed_components_of(side).any())
        for (const std::string &column :
             ReactionSum<dim>::columns_of(beginning_of(side)))
          card.ledger_columns.push_back(column);
    card.is_present = boundary_conditions;
    return card;
  }

  template <int dim>
  void
  Reactions<dim>::see_reactions(const ActiveGrid<dim> &active,
                                const Vector          &force)
  {
    sums       = {};
    auto entry = force.begin();
    for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
      {
        const dealii::Point<dim> x    = active.position(node);
        const auto               here = boundary_conditions.sides_at(x);
        for (unsigned int c = 0; c < dim; ++c, ++entry)
          {
            const auto holds = [&](const unsigned int side) {
              return here[side] &&
                     boundary_conditions.fixed_components_of(side)[c];
            };
            unsigned int side = 2 * c;
            if (!holds(side) && !holds(++side))
              for (side = 0; side < 2 * dim && !holds(side);)
                ++side;
            if (side == 2 * dim)
              continue;
            sums[side].add(x, c, -*entry); // that on the body is the residual
          }
      }
  }

  template <int dim>
  std::vector<StepMeasure>
  Reactions<dim>::measure(const PointArrays<dim> &,
                          const double,
                          const BackgroundGrid<dim> &grid)
  {
    std::vector<StepMeasure> result;
    for (unsigned int side = 0; side < 2 * dim; ++side)
      if (boundary_conditions.fixed_components_of(side).any())
        sums[side].append_to(result, beginning_of(side), grid.communicator());
    return result;
  }

  template class ReactionSum<2>;
  template class ReactionSum<3>;
  template class Reactions<2>;
  template class Reactions<3>;
} // namespace emmy
