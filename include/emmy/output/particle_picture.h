#ifndef emmy_output_particle_picture_h
#define emmy_output_particle_picture_h

#include <deal.II/base/point.h>

#include <array>
#include <iosfwd>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * The gnuplot script that shows the particles at several times, one panel
   * each, coloured by a value with one common scale, over the lines of the
   * background grid. Used by Pictures.
   *
   * In 3D the points are projected by the script (parallel, from the front
   * right and above, z upwards), since gnuplot's own 3D points hide each other
   * in the order of the file and have no size in metres. So the files must
   * hold the points sorted by depth(), as Pictures writes them.
   */
  struct ParticlePicture
  {
    /** One time; files are relative to the script. */
    struct Panel
    {
      double      time; ///< s
      std::string file; ///< columns x, y, (z,) value; empty: no particles
      /** Lines, or outlines of triangles, by x, y, (z); empty: none. */
      std::string surfaces;
    };

    unsigned int dim = 2;     ///< of the scene
    std::string  title;       ///< plain text
    std::string  value_label; ///< gnuplot's enhanced text, with the unit

    /**
     * The box of the background grid to be shown, m, and the size of its
     * cells. The third component is not used in 2D.
     */
    dealii::Point<3>     lower, upper;
    dealii::Tensor<1, 3> line_distance; ///< m

    double spacing  = 1.; ///< of neighbouring particles, m
    double smallest = 0.; ///< of all values
    double largest  = 1.; ///< of the colours' field
    /** The values of the first and the last colour. */
    double             first_colour = 0., last_colour = 1.;
    std::vector<Panel> panels; ///< one a time

    /**
     * Let colours range from the 1st to the 99th percentile of the values in
     * the files of the panels: they do not hang on a few particles at an
     * edge. Where these are the same, over all values. Cost: the files are
     * read once.
     */
    void
    choose_colours(const std::string &folder);

    /** Write the complete script. */
    void
    write_script(std::ostream &script) const;

    /** How near to the viewer a point is: draw in ascending order. */
    static double
    depth(const dealii::Point<3> &point);
  };
} // namespace emmy

#endif
