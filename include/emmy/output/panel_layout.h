#ifndef emmy_output_panel_layout_h
#define emmy_output_panel_layout_h

#include <emmy/output/gnuplot.h>
#include <emmy/output/particle_picture.h>

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <cstddef>

namespace emmy
{
  /**
   * The parallel projection of 3D pictures: seen from 55 degrees off the
   * x-axis towards -y and 22 degrees above the plane. Orthonormal.
   */
  struct Projection
  {
    /** Directions of the paper in space. */
    static const dealii::Tensor<1, 3> to_the_right, upwards, to_the_eye;
  };

  /** Where a point is drawn, in m on the paper; itself in 2D. */
  dealii::Point<2>
  project(const ParticlePicture &picture, const dealii::Point<3> &point);


  /**
   * How the panels of a ParticlePicture are placed, in rows, with equal scales
   * in both directions, and how large the canvas is. Lengths in pixels, except
   * where noted.
   */
  struct PanelLayout
  {
    /** The layout with so many columns. */
    PanelLayout(const ParticlePicture &picture, const unsigned int n_columns);

    /** The layout that uses a page best. */
    static PanelLayout
    best(const ParticlePicture &picture);

    gnuplot::Canvas canvas; ///< pixels of the whole
    /** Of panels. */
    unsigned int n_columns, n_rows;
    /** Pixels; in 3D with the axes. */
    double panel_width, panel_height;
    double pixels_per_metre; ///< of all panels
    /** Corners of a panel, m. */
    dealii::Point<2> paper_lower, paper_upper;
    /** Margins and gaps, pixels. */
    double left, top, column_gap, row_gap, bar_width;

  private:
    /** How far the figure is from one that fills a part of a page. */
    double
    badness(const std::size_t n_panels) const;
  };
} // namespace emmy

#endif
