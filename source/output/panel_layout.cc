#include <emmy/output/panel_layout.h>

#include <deal.II/base/numbers.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace emmy
{
  using dealii::Point;
  using dealii::Tensor;

  namespace
  {
    const double azimuth   = -55. / 180. * dealii::numbers::PI;
    const double elevation = 22. / 180. * dealii::numbers::PI;


    /** What a panel covers, in m on the paper: two opposite corners. */
    std::pair<Point<2>, Point<2>>
    extent_on_paper(const ParticlePicture &picture)
    {
      const Point<3> corners[2] = {picture.lower, picture.upper};
      Point<2>       lowest     = project(picture, picture.lower);
      Point<2>       highest    = lowest;
      for (unsigned int i = 0; i < 8; ++i)
        {
          const Point<2> place = project(picture,
                                         {corners[i & 1][0],
                                          corners[(i >> 1) & 1][1],
                                          corners[(i >> 2) & 1][2]});
          for (unsigned int d = 0; d < 2; ++d)
            {
              lowest[d]  = std::min(lowest[d], place[d]);
              highest[d] = std::max(highest[d], place[d]);
            }
        }
      return {lowest, highest};
    }
  } // namespace


  const Tensor<1, 3>
    Projection::to_the_right({-std::sin(azimuth), std::cos(azimuth), 0.});
  const Tensor<1, 3>
    Projection::upwards({-std::sin(elevation) * std::cos(azimuth),
                         -std::sin(elevation) * std::sin(azimuth),
                         std::cos(elevation)});
  const Tensor<1, 3>
    Projection::to_the_eye({std::cos(elevation) * std::cos(azimuth),
                            std::cos(elevation) * std::sin(azimuth),
                            std::sin(elevation)});


  Point<2>
  project(const ParticlePicture &picture, const Point<3> &point)
  {
    if (picture.dim == 2)
      return {point[0], point[1]};
    return {point * Projection::to_the_right, point * Projection::upwards};
  }


  PanelLayout::PanelLayout(const ParticlePicture &picture,
                           const unsigned int     n_columns)
    : n_columns(n_columns)
    , n_rows((picture.panels.size() + n_columns - 1) / n_columns)
  {
    // Room for letters. The axes of a 3D box are a part of its panel.
    const double font      = canvas.font;
    const bool   is_flat   = picture.dim == 2;
    const double pad_left  = is_flat ? 0. : 3. * font;
    const double pad_right = is_flat ? 0. : 3. * font;
    const double pad_low   = is_flat ? 0. : 2.2 * font;
    const double bottom    = is_flat ? 8.8 * font : 6. * font;
    const double letters_x =
      gnuplot::longest_number(picture.lower[0], picture.upper[0]);
    const double letters_y =
      gnuplot::longest_number(picture.lower[1], picture.upper[1]);
    const double right = is_flat ? (0.6 + 0.3 * letters_x) * font : font;
    left               = is_flat ? (3.6 + 0.6 * letters_y) * font : font;
    top                = (picture.title.empty() ? 2. : 4.) * font;
    column_gap         = 1.4 * font;
    row_gap            = 2. * font;

    // Either the width of the canvas or a greatest height sets the scale.
    std::tie(paper_lower, paper_upper) = extent_on_paper(picture);
    const Tensor<1, 2> content         = paper_upper - paper_lower;
    const double       all_gaps        = (n_columns - 1) * column_gap;
    const double greatest_height = std::clamp(1560. / n_rows, 300., 1300.);
    pixels_per_metre =
      std::min(((canvas.width - left - right - all_gaps) / n_columns -
                pad_left - pad_right) /
                 content[0],
               greatest_height / content[1]);
    panel_width  = pixels_per_metre * content[0] + pad_left + pad_right;
    panel_height = pixels_per_metre * content[1] + pad_low;
    paper_lower[0] -= pad_left / pixels_per_metre;
    paper_lower[1] -= pad_low / pixels_per_metre;
    paper_upper[0] += pad_right / pixels_per_metre;

    // A narrow panel leaves room for its title and numbers, and the figure
    // for the colour bar and its label.
    column_gap = std::max(column_gap, 9. * font - panel_width);
    const double width =
      left + right + n_columns * panel_width + (n_columns - 1) * column_gap;
    canvas.width = std::max(width, 28. * font);
    canvas.height =
      top + n_rows * panel_height + (n_rows - 1) * row_gap + bottom;
    left += (canvas.width - width) / 2.;
    bar_width = std::min(0.7 * canvas.width, 36. * font);
  }


  double
  PanelLayout::badness(const std::size_t n_panels) const
  {
    const double paper = canvas.width * canvas.height;
    const double used  = n_panels * panel_width * panel_height / paper;
    const double empty =
      1. - static_cast<double>(n_panels) / (n_rows * n_columns);
    return std::abs(std::log(canvas.height / canvas.width / 0.65)) -
           1.5 * std::log(used) + 2. * empty;
  }


  PanelLayout
  PanelLayout::best(const ParticlePicture &picture)
  {
    PanelLayout best(picture, 1);
    for (unsigned int n = 2;
         n <= std::min<std::size_t>(picture.panels.size(), 8);
         ++n)
      {
        const PanelLayout other(picture, n);
        if (other.badness(picture.panels.size()) <
            best.badness(picture.panels.size()))
          best = other;
      }
    return best;
  }
} // namespace emmy
