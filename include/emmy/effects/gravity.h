#ifndef emmy_effects_gravity_h
#define emmy_effects_gravity_h

#include <emmy/effects/field_load.h>

namespace emmy
{
  /** Section `Effects/Gravity`. */
  template <int dim>
  class GravityParameters : public EffectParameters<dim>,
                            public UniformAcceleration<dim>,
                            public GivenOverTime
  {
  public:
    /** Declares the entries of a section. */
    explicit GravityParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

    dealii::Tensor<1, dim>
    vector() const override;
    std::vector<TimeHistory>
    histories() const override;

  private:
    std::vector<double> acceleration; // m/s^2
    AmplitudeParameters amplitude;
  };

  /**
   * Gravity: f_A = a sum S_Ap m_p g. With a constant amplitude its work over a
   * step is the loss of potential energy, exactly.
   */
  template <int dim>
  using Gravity = FieldLoad<dim>;
} // namespace emmy

#endif
