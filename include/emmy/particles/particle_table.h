#ifndef emmy_particles_particle_table_h
#define emmy_particles_particle_table_h

#include <emmy/particles/shape.h>

#include <string>
#include <vector>

namespace emmy
{
  /**
   * The particles of a body that are listed one by one, not made from a shape.
   */
  template <int dim>
  struct ParticleTable
  {
    std::vector<dealii::Point<dim>> positions; ///< m
    std::vector<double> volumes; ///< m^3, in plane strain m^2; positive
    /** m/s, on top of the body's; may be empty. */
    std::vector<dealii::Tensor<1, dim>> velocities;
  };

  /**
   * A file whose first line names its columns, separated by commas,
   * semicolons or blanks: x, y (and z), volume, and, all or none, vx, vy (and
   * vz). Lines that begin with # do not count.
   *
   * The shape contains the boxes of its particles, squares or cubes of the
   * mean volume. Throws ExcParameter for @p section, entry File, with the
   * line that is wrong.
   */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_particle_table(const std::string &file, const std::string &section);
} // namespace emmy

#endif
