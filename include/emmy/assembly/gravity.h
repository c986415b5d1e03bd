#ifndef emmy_assembly_gravity_h
#define emmy_assembly_gravity_h

#include <emmy/assembly/force_term.h>

namespace emmy
{
  /** Section `Effects/Gravity`. */
  template <int dim>
  class GravityParameters : public EffectParameters<dim>
  {
  public:
    explicit GravityParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

  private:
    std::vector<double> acceleration; // m/s^2
  };

  /**
   * Gravity: f_A = sum S_Ap m_p g. Its work over a step is the loss of
   * potential energy, exactly.
   */
  template <int dim>
  class Gravity : public StepLoad<dim>
  {
  public:
    Gravity(const dealii::Tensor<1, dim> &acceleration,
            const unsigned int            mass_component);

    void
    add(const StepData<dim> &step,
        std::vector<double> &local_force) const override;

  private:
    const dealii::Tensor<1, dim> acceleration;
    const unsigned int           mass_component;
  };
} // namespace emmy

#endif
