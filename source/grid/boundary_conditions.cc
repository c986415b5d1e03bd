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

  template <int dim>
  BoundaryConditions<dim>::BoundaryConditions(
    const BoundaryParameters  &parameters,
    const BackgroundGrid<dim> &grid)
    : grid(grid)
  {
    const std::vector<std::string> names = side_names(dim);
    const auto side_of = [&](const std::string &name, const char *entry) {
      const auto position = std::find(names.begin(), names.end(), name);
      AssertThrow(position != names.end(),
                  ExcParameter(parameters.path(),
                               entry,
                               name,
                               "the grid has no such side. Its sides are " +
                                 join(names) + "."));
      return static_cast<unsigned int>(position - names.begin());
    };
    for (const std::string &name : parameters.fixed)
      fixed_on_side[side_of(name, "Fixed")].set();
    for (const std::string &name : parameters.roller)
      {
        const unsigned int side = side_of(name, "Roller");
        fixed_on_side[side].set(side / 2);
      }
  }

  template <int dim>
  std::bitset<dim>
  BoundaryConditions<dim>::fixed_components(
    const dealii::Point<dim> &position) const
  {
    std::bitset<dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double tolerance = 1e-6 * grid.cell_size()[d];
        if (std::abs(position[d] - grid.lower_corner()[d]) < tolerance)
          result |= fixed_on_side[2 * d];
        if (std::abs(position[d] - grid.upper_corner()[d]) < tolerance)
          result |= fixed_on_side[2 * d + 1];
      }
    return result;
  }

  template class BoundaryConditions<2>;
  template class BoundaryConditions<3>;
} // namespace emmy
