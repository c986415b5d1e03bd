#ifndef emmy_particles_shape_formula_h
#define emmy_particles_shape_formula_h

#include <emmy/particles/shape.h>

namespace emmy
{
  /** Whether an entry <Shape> is a formula, and not a name of the library. */
  inline bool
  is_shape_formula(const std::string &text)
  {
    return text.find('(') != std::string::npos;
  }

  /**
   * Read a shape that is written in one line, e.g.
   * difference(box(0, 0; 4, 1), ball(2, 0.5; 0.2)).
   *
   * Items stand between commas or semicolons; a number may be a formula
   * without variables, e.g. 2/3 or 0.5*sqrt(2). doc/geometry.md lists the
   * functions. Throws ExcParameter for @p section, entry <Shape>, which
   * says where the formula is wrong and what was expected there.
   */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_shape(const std::string &text, const std::string &section);
} // namespace emmy

#endif
