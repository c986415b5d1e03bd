#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/grid/boundary_conditions.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  BoundaryParameters::BoundaryParameters(const std::string &section)
    : Section(section)
  {
    const dealii::Patterns::List sides(dealii::Patterns::Anything(), 0);
    add_parameter("Fixed",
                  fixed,
                  "Sides of the grid where all components of the displacement "
                  "are zero. A list of x-min, x-max, y-min, y-max, z-min, "
                  "z-max.",
                  prm,
                  sides);
    add_parameter("Roller",
                  roller,
                  "Sides of the grid where the normal component of the "
                  "displacement is zero. A list of sides, as for <Fixed>.",
                  prm,
                  sides);
    add_parameter("Held parts",
                  held_parts,
                  "Names of parts of space whose nodes move as they are told, "
                  "e.g. those under a rigid footing. Each has a section of its "
                  "name. The ledger has the force and the moment about the "
                  "origin on each: held_NAME_force_x and so on.",
                  prm,
                  dealii::Patterns::List(dealii::Patterns::Anything(), 0));
  }

  std::vector<std::string>
  side_names(const unsigned int dim)
  {
    std::vector<std::string> names;
    for (unsigned int d = 0; d < dim; ++d)
      for (const char *end : {"-min", "-max"})
        names.push_back(std::string(1, "xyz"[d]) + end);
    return names;
  }

  unsigned int
  side_number(const std::string &name,
              const unsigned int dim,
              const std::string &section,
              const std::string &entry)
  {
    const std::vector<std::string> names = side_names(dim);
    const auto        position = std::find(names.begin(), names.end(), name);
    const std::string nearest  = nearest_name(name, names);
    AssertThrow(position != names.end(),
                ExcParameter(section,
                             entry,
                             name,
                             "the grid has no such side. " +
                               (nearest.empty()
                                  ? std::string()
                                  : "Did you mean <" + nearest + ">? ") +
                               "Its sides are " + join(names) +
                               ". Commas separate several."));
    return position - names.begin();
  }

  template <int dim>
  BoundaryConditions<dim>::BoundaryConditions(
    const BoundaryParameters  &parameters,
    const BackgroundGrid<dim> &grid,
    std::vector<HeldPart<dim>> held_parts)
    : grid(grid)
    , parts(std::move(held_parts))
  {
    const std::string section = parameters.path();
    for (const std::string &name : parameters.fixed)
      fixed_on_side[side_number(name, dim, section, "Fixed")].set();
    for (const std::string &name : parameters.roller)
      {
        const unsigned int side = side_number(name, dim, section, "Roller");
        fixed_on_side[side].set(side / 2);
      }
  }

  template <int dim>
  std::bitset<2 * dim>
  BoundaryConditions<dim>::sides_at(const dealii::Point<dim> &position) const
  {
    std::bitset<2 * dim> sides;
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double tolerance = 1e-6 * grid.cell_size()[d];
        sides[2 * d] =
          std::abs(position[d] - grid.lower_corner()[d]) < tolerance;
        sides[2 * d + 1] =
          std::abs(position[d] - grid.upper_corner()[d]) < tolerance;
      }
    return sides;
  }

  template <int dim>
  std::bitset<dim>
  BoundaryConditions<dim>::fixed_by_sides(
    const dealii::Point<dim> &position) const
  {
    const auto       sides = sides_at(position);
    std::bitset<dim> result;
    for (unsigned int side = 0; side < 2 * dim; ++side)
      if (sides[side])
        result |= fixed_on_side[side];
    return result;
  }

  template <int dim>
  std::bitset<dim>
  BoundaryConditions<dim>::fixed_components(
    const dealii::Point<dim> &position) const
  {
    std::bitset<dim> result = fixed_by_sides(position);
    for (const HeldPart<dim> &part : parts)
      if (part.region->value(position) > 0.)
        result |= part.components;
    return result;
  }

  template <int dim>
  unsigned int
  BoundaryConditions<dim>::part_that_holds(const dealii::Point<dim> &position,
                                           const unsigned int component) const
  {
    if (fixed_by_sides(position)[component])
      return parts.size();
    unsigned int part = 0;
    while (part < parts.size() && !(parts[part].components[component] &&
                                    parts[part].region->value(position) > 0.))
      ++part;
    return part;
  }

  template <int dim>
  bool
  BoundaryConditions<dim>::is_wall(const unsigned int side) const
  {
    return fixed_on_side[side][side / 2];
  }

  template <int dim>
  bool
  BoundaryConditions<dim>::has_walls() const
  {
    return !parts.empty() ||
           std::any_of(fixed_on_side.begin(),
                       fixed_on_side.end(),
                       [](const auto &fixed) { return fixed.any(); });
  }

  template <int dim>
  std::bitset<dim>
  BoundaryConditions<dim>::fixed_components_of(const unsigned int side) const
  {
    return fixed_on_side[side];
  }

  template class BoundaryConditions<2>;
  template class BoundaryConditions<3>;
} // namespace emmy
