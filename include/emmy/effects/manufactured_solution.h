#ifndef emmy_effects_manufactured_solution_h
#define emmy_effects_manufactured_solution_h

#include <emmy/effects/effect.h>
#include <emmy/effects/exact_motion.h>
#include <emmy/material/material.h>

namespace emmy
{
  /**
   * Section `Effects/Manufactured solution`: bodies get the body force that
   * makes a motion in closed form the solution, start with its velocity, and
   * the ledger says how far the particles are from it.
   *
   * Particles carry the field `reference_position`. Only for elastic
   * materials, whose stress is known where the deformation is.
   */
  template <int dim>
  class ManufacturedSolutionParameters : public EffectParameters<dim>
  {
  public:
    /** Declares the entries of a section. */
    explicit ManufacturedSolutionParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

  private:
    std::string              motion = "vibration";
    double                   period = 0.; // s
    VibrationParameters<dim> vibration;
    VortexParameters<dim>    vortex;
  };

  /**
   * The body force per mass that makes a motion the solution for an elastic
   * material, b = a - Div P / rho_0, at points of the undeformed body. With
   * l_J = dF/dX_J F^-1, d_J its symmetric part and c the spatial tangent,
   *   Div P = sum_J (c : d_J + l_J tau) F^-T e_J.
   *
   * Cost per point: one material evaluation with tangent.
   *
   * @param points positions X at t = 0, m
   * @return m/s^2
   */
  template <int dim>
  std::vector<dealii::Tensor<1, dim>>
  exact_body_force(const ExactMotion<dim>                &motion,
                   const Material<dim>                   &material,
                   const std::vector<dealii::Point<dim>> &points,
                   const double                           time);
} // namespace emmy

#endif
