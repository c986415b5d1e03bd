#ifndef emmy_grid_held_part_h
#define emmy_grid_held_part_h

#include <deal.II/base/function_parser.h>

#include <emmy/base/section.h>

#include <bitset>
#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * A part of space whose nodes move as they are told, e.g. those under a
   * rigid footing. Owned by the boundary conditions.
   */
  template <int dim>
  struct HeldPart
  {
    std::string                                  name;   ///< as in `Held parts`
    std::shared_ptr<dealii::FunctionParser<dim>> region; ///< positive inside
    std::bitset<dim>                             components; ///< that are held
    /** Of the components that are held, in t; null of others. m/s */
    std::vector<std::shared_ptr<dealii::FunctionParser<1>>> velocity;

    /** Of the components at a time, s; zero where they are free. m/s */
    dealii::Tensor<1, dim>
    velocity_at(const double time) const;

    /** Their integral, by a Gauss rule with four points, m. */
    dealii::Tensor<1, dim>
    displacement_over(const double time, const double time_step) const;
  };

  /** Section `Boundary conditions/NAME` of a held part. */
  template <int dim>
  class HeldPartParameters : public Section
  {
  public:
    /** Declares the entries of a section. */
    explicit HeldPartParameters(const std::string &section);

    /** Throws ExcParameter. */
    HeldPart<dim>
    make() const;

  private:
    const std::string name;
    std::string       region, velocity;
  };
} // namespace emmy

#endif
