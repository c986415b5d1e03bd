#ifndef emmy_particles_particle_columns_h
#define emmy_particles_particle_columns_h

#include <string>
#include <vector>

namespace emmy
{
  /** Numbers of particles as they stand in a file. */
  struct ParticleColumns
  {
    std::vector<std::string>         names;   ///< one a column
    std::vector<std::vector<double>> rows;    ///< one a particle, all finite
    std::string                      problem; ///< empty: none

    /** The number of a column; -1: there is none. */
    int
    find(const std::string &name) const;
  };

  /**
   * A table as text (.csv or any other ending but .vtu): the first line names
   * its columns, which commas, semicolons or blanks separate. Lines that begin
   * with # do not count.
   */
  ParticleColumns
  read_text_columns(const std::string &file);

  /**
   * The points of a file of VTK (.vtu, XML), with their arrays: as text or
   * base64, compressed by zlib or not, within the arrays. Columns are x, y, z;
   * NAME of a scalar; NAME_x, NAME_y, NAME_z of a vector; NAME_xx, NAME_yy,
   * NAME_zz, NAME_xy, NAME_xz, NAME_yz of a tensor.
   */
  ParticleColumns
  read_vtu_columns(const std::string &file);
} // namespace emmy

#endif
