#ifndef emmy_particles_initial_stress_h
#define emmy_particles_initial_stress_h

#include <deal.II/base/function_parser.h>

#include <emmy/base/section.h>
#include <emmy/math/mandel.h>

#include <memory>
#include <string>

namespace emmy
{
  /**
   * The effective stress in level ground: by depth, with the vertical upwards
   * along the last axis,
   * @f[ \sigma_v = -(q + \int \gamma\,dz),\quad \sigma_h = K_0\,\sigma_v , @f]
   * where gamma is the weight of the ground, below the water that of what the
   * water leaves.
   */
  struct LevelGround
  {
    double surface_level;       ///< m
    double unit_weight;         ///< N/m^3
    double water_level;         ///< m
    double buoyant_unit_weight; ///< N/m^3
    double surcharge;           ///< q, Pa
    double lateral_ratio;       ///< K_0

    /** sigma_v at a height, Pa. */
    double
    vertical_stress(const double height) const;
  };

  /**
   * The Cauchy stress that a body has at the start, by place. Owned by its
   * body; asked once for each particle.
   */
  template <int dim>
  class InitialStress
  {
  public:
    /** Of level ground. */
    explicit InitialStress(const LevelGround &ground);

    /** @param components xx; yy; zz; xy (; xz; yz), Pa */
    explicit InitialStress(
      std::unique_ptr<dealii::FunctionParser<dim>> components);

    /** Pa, positive in tension. */
    MandelVector<dim>
    at(const dealii::Point<dim> &place) const;

  private:
    const LevelGround                                  ground = {};
    const std::unique_ptr<dealii::FunctionParser<dim>> components;
  };

  /** The entries of `Bodies/NAME` on it. */
  class InitialStressParameters
  {
  public:
    std::string kind = "none"; ///< `none`, `level ground` or `formulas`

    /** Declare the entries. */
    void
    add_to(Section &section, const unsigned int dim);

    /** Null: there is none. Throws ExcParameter with the section's path. */
    template <int dim>
    std::unique_ptr<InitialStress<dim>>
    make(const std::string &section) const;

  private:
    std::string surface_level, water_level, lateral_ratio; // may be empty
    double      unit_weight = 0., buoyant_unit_weight = 0., surcharge = 0.;
    std::string components;
  };
} // namespace emmy

#endif
