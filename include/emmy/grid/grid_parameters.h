#ifndef emmy_grid_grid_parameters_h
#define emmy_grid_grid_parameters_h

#include <deal.II/base/point.h>

#include <emmy/base/section.h>

#include <string>
#include <vector>

namespace emmy
{
  /** Section `Grid`. */
  template <int dim>
  class GridParameters : public Section
  {
  public:
    dealii::Point<dim> lower_corner; ///< m
    dealii::Point<dim> upper_corner; ///< m; must be above lower_corner
    /** One number per direction. */
    std::vector<unsigned int> cells = std::vector<unsigned int>(dim, 0);

    /** Declares the entries of the section. */
    explicit GridParameters(const std::string &section = "Grid");

    /** Throws ExcParameter for an empty grid or cells that do not fit. */
    void
    validate() const;
  };
} // namespace emmy

#endif
