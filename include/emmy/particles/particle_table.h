#ifndef emmy_particles_particle_table_h
#define emmy_particles_particle_table_h

#include <emmy/particles/particle_columns.h>
#include <emmy/particles/shape.h>

#include <string>
#include <vector>

namespace emmy
{
  /** A file with particles, and which of its rows and columns count. */
  struct TableFile
  {
    std::string file;      ///< its name
    int         body = -1; ///< rows whose column <body> is that; -1: all
    std::vector<std::string> left_out; ///< columns that do not count
    std::string              section;  ///< what messages name
  };

  /**
   * The particles of a body that are listed one by one, not made from a shape.
   */
  template <int dim>
  struct ParticleTable
  {
    TableFile                       from;      ///< where they were read
    std::vector<dealii::Point<dim>> positions; ///< m
    /** As they are, m^3, in plane strain m^2; positive. */
    std::vector<double> volumes;
    std::vector<double> masses; ///< kg; empty: by the density of the material
    /** m/s, on top of the body's; may be empty. */
    std::vector<dealii::Tensor<1, dim>> velocities;
    /** All other columns, which say what particles have suffered. */
    ParticleColumns state;
  };

  /**
   * A file with the columns x, y (and z), volume (or reference_volume, with
   * left_cauchy_green or logarithmic_strain if they have changed it), and, if
   * wanted, vx, vy (and vz), mass or density, body, and what
   * set_table_states() knows. CSV or VTU, by its ending.
   *
   * The shape contains the boxes of its particles, squares or cubes of the
   * mean volume. Throws ExcParameter for the section, entry File, with the
   * line that is wrong.
   */
  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_particle_table(const TableFile &from);
} // namespace emmy

#endif
