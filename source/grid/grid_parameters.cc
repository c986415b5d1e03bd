#include <emmy/base/exceptions.h>
#include <emmy/base/index_limits.h>
#include <emmy/grid/grid_parameters.h>

namespace emmy
{
  template <int dim>
  GridParameters<dim>::GridParameters(const std::string &section)
    : Section(section)
  {
    this->add_parameter("Lower corner",
                        lower_corner,
                        "Coordinates of the grid's lower corner. Unit: m.");
    this->add_parameter("Upper corner",
                        upper_corner,
                        "Coordinates of the grid's upper corner. Unit: m. "
                        "Required: above the lower corner in each direction.");
    this->add_parameter("Cells",
                        cells,
                        "Number of equal cells per direction. Required. "
                        "Where no body is near they cost nothing, but for a "
                        "body that is an expression without corners.",
                        this->prm,
                        dealii::Patterns::List(dealii::Patterns::Integer(0),
                                               dim,
                                               dim));
  }

  template <int dim>
  void
  GridParameters<dim>::validate() const
  {
    const std::string section = this->path();
    for (unsigned int d = 0; d < dim; ++d)
      {
        AssertThrow(cells[d] > 0,
                    ExcParameter(section,
                                 "Cells",
                                 dealii::Patterns::Tools::to_string(cells),
                                 "the number of cells in each direction is "
                                 "required and must be at least 1."));
        AssertThrow(
          upper_corner[d] > lower_corner[d],
          ExcParameter(section,
                       "Upper corner",
                       dealii::Patterns::Tools::to_string(upper_corner),
                       "must lie above the lower corner (" +
                         dealii::Patterns::Tools::to_string(lower_corner) +
                         ") in each direction. Coordinates are in m."));
      }
    refuse_lattice(cells);
  }

  template class GridParameters<2>;
  template class GridParameters<3>;
} // namespace emmy
