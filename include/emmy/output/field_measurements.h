#ifndef emmy_output_field_measurements_h
#define emmy_output_field_measurements_h

#include <emmy/output/measurement.h>

namespace emmy
{
  /**
   * The measurements that read fields of particles, all that ParticleFields
   * knows. Columns are NAME_FIELD_xx, without xx for scalars, and NAME_x for
   * the position.
   *
   * particle: those that start nearest to a position; of several equally near
   * ones their mean. They are followed.
   */
  template <int dim>
  std::unique_ptr<MeasurementParameters<dim>>
  make_particle_parameters(const std::string &section);

  /**
   * mean: of the particles whose centres are in a box, which stays where it
   * is, at the end of the step: sum of V f / sum of V with V = J V_0, the
   * volume now. A column NAME_volume has the sum of V; where it is 0 so are
   * the means.
   */
  template <int dim>
  std::unique_ptr<MeasurementParameters<dim>>
  make_mean_parameters(const std::string &section);
} // namespace emmy

#endif
