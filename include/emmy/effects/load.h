#ifndef emmy_effects_load_h
#define emmy_effects_load_h

#include <vector>

namespace emmy
{
  template <int dim>
  struct StepData;

  /** A force that is fixed within a step. See Effect::load(). */
  template <int dim>
  class Load
  {
  public:
    virtual ~Load() = default;

    /** Add it to an array over local nodes: [dim * node + c], N. */
    virtual void
    add_load(const StepData<dim> &step,
             std::vector<double> &local_force) const = 0;

    /**
     * Add it to an array over points, [dim * p + c], N, such that add_load()
     * gives sum_p S_Ap f_p. Newton needs it where the particles' places are
     * unknowns; with a load that has no such form it takes some more
     * iterations.
     */
    virtual void
    add_load_at_points(const StepData<dim> &step,
                       std::vector<double> &point_force) const
    {
      (void)step;
      (void)point_force;
    }
  };
} // namespace emmy

#endif
