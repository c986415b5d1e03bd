#ifndef emmy_effects_field_load_h
#define emmy_effects_field_load_h

#include <emmy/effects/amplitude.h>
#include <emmy/effects/effect.h>

namespace emmy
{
  /** The parameters of an effect that accelerates all bodies alike. */
  template <int dim>
  class UniformAcceleration
  {
  public:
    virtual ~UniformAcceleration() = default;

    /** m/s^2; as given, and zero if it is not complete. */
    virtual dealii::Tensor<1, dim>
    vector() const = 0;
  };

  /**
   * A load that particles hold: f_A = a sum_p S_Ap w_p q, with w_p a scalar
   * field of the particles, q a constant vector and a the amplitude of the
   * step. Its work over a step is sum_p a w_p q . dx_p, exactly.
   *
   * Gravity: the mass and the acceleration. Point load: the share and the
   * force. Owned by the balance; cost: one pass over the particles per try of
   * a step.
   */
  template <int dim>
  class FieldLoad : public Effect<dim>, public Load<dim>
  {
  public:
    /**
     * @param vector    q; w_p q in N
     * @param component of w_p in the field layout
     */
    FieldLoad(const dealii::Tensor<1, dim> &vector,
              const unsigned int            component,
              Amplitude                     amplitude = Amplitude());

    const Load<dim> *
    load() const override
    {
      return this;
    }
    void
    add_load(const StepData<dim> &step,
             std::vector<double> &local_force) const override;
    void
    add_load_at_points(const StepData<dim> &step,
                       std::vector<double> &point_force) const override;

  private:
    const dealii::Tensor<1, dim> vector;
    const unsigned int           component;
    const Amplitude              amplitude;
  };
} // namespace emmy

#endif
