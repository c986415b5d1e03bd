#ifndef emmy_effects_given_motion_h
#define emmy_effects_given_motion_h

#include <emmy/system/active_grid.h>

#include <string>

namespace emmy
{
  /**
   * The motion that an effect gives to components which essential conditions
   * fix; without one they rest. See Effect::given_motion().
   */
  template <int dim>
  class GivenMotion
  {
  public:
    virtual ~GivenMotion() = default;

    /**
     * Add to @p velocity, m/s, that of fixed unknowns at a time, s. Collective.
     */
    virtual void
    add_velocity(const ActiveGrid<dim> &active,
                 const double           time,
                 Vector                &velocity) const = 0;

    /** The same of the displacement over a step from @p time on, m. */
    virtual void
    add_displacement(const ActiveGrid<dim> &active,
                     const double           time,
                     const double           time_step,
                     Vector                &displacement) const = 0;

    /** The column of the ledger that has the work of what holds them. */
    virtual std::string
    work_column() const = 0;
  };
} // namespace emmy

#endif
