#include <deal.II/base/utilities.h>

#include <emmy/output/animation.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace emmy
{
  namespace
  {
    constexpr unsigned int steps      = 65535; ///< of a coded number
    constexpr std::size_t  most_lines = 3000;  ///< in a frame

    /** Between which values a component lies in most of the numbers. */
    std::array<double, 2>
    range(std::vector<float> values, const double left_out)
    {
      values.erase(std::remove_if(values.begin(),
                                  values.end(),
                                  [](const float x) {
                                    return !std::isfinite(x);
                                  }),
                   values.end());
      if (values.empty())
        return {{0., 1.}};
      std::sort(values.begin(), values.end());
      const std::size_t out = left_out * (values.size() - 1);
      return {{values[out], values[values.size() - 1 - out]}};
    }

    /** Every @p stride -th number of all frames, from @p first on. */
    std::vector<float>
    component(const std::vector<FilmFrame> &frames,
              std::vector<float> FilmFrame::*numbers,
              const unsigned int             first,
              const unsigned int             stride)
    {
      std::vector<float> result;
      for (const FilmFrame &frame : frames)
        for (std::size_t i = first; i < (frame.*numbers).size(); i += stride)
          result.push_back((frame.*numbers)[i]);
      return result;
    }

    /** Base64 of 16-bit numbers, each in the range of its component. */
    std::string
    coded(const std::vector<float>                 &numbers,
          const std::vector<std::array<double, 2>> &ranges)
    {
      std::vector<unsigned char> bytes;
      for (std::size_t i = 0; i < numbers.size(); ++i)
        {
          const auto  &ends = ranges[i % ranges.size()];
          const double size = ends[1] - ends[0],
                       part = size > 0. ? (numbers[i] - ends[0]) / size : 0.;
          const unsigned int code =
            std::lround(steps * std::min(1., std::max(0., part)));
          bytes.push_back(code % 256);
          bytes.push_back(code / 256);
        }
      return dealii::Utilities::encode_base64(bytes);
    }

    template <int dim>
    void
    append(const dealii::Point<dim> &x, std::vector<float> &numbers)
    {
      for (unsigned int d = 0; d < dim; ++d)
        numbers.push_back(x[d]);
    }

    /** Sides of triangles that are shared count once. */
    template <int dim>
    std::vector<std::array<dealii::Point<dim>, 2>>
    lines_of(const std::vector<Surface<dim>> &surfaces)
    {
      using Line           = std::array<dealii::Point<dim>, 2>;
      const auto is_before = [](const auto &a, const auto &b) {
        return std::lexicographical_compare(a.begin_raw(),
                                            a.end_raw(),
                                            b.begin_raw(),
                                            b.end_raw());
      };
      std::vector<Line> lines;
      for (const Surface<dim> &surface : surfaces)
        for (const auto &facet : surface.facets)
          for (unsigned int v = 0; v < (dim == 2 ? 1 : dim); ++v)
            {
              Line line{{facet[v], facet[(v + 1) % dim]}};
              if (is_before(line[1], line[0]))
                std::swap(line[0], line[1]);
              lines.push_back(line);
            }
      const auto comes_first = [&](const Line &a, const Line &b) {
        return a[0] == b[0] ? is_before(a[1], b[1]) : is_before(a[0], b[0]);
      };
      std::sort(lines.begin(), lines.end(), comes_first);
      lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
      const std::size_t stride = 1 + lines.size() / most_lines;
      std::vector<Line> result;
      for (std::size_t i = 0; i < lines.size(); i += stride)
        result.push_back(lines[i]);
      return result;
    }
  } // namespace

  Animation::Animation(const unsigned int      dim,
                       const std::string      &label,
                       std::vector<FilmFrame> &frames)
    : dim(dim)
    , label(label)
    , frames(frames)
  {}

  template <int spacedim>
  void
  Animation::add(const double                                time,
                 const std::vector<dealii::Point<spacedim>> &positions,
                 const std::vector<double>                  &values,
                 const std::vector<Surface<spacedim>>       &surfaces)
  {
    FilmFrame frame;
    frame.time = time;
    for (std::size_t p = 0; p < positions.size(); ++p)
      {
        append(positions[p], frame.points);
        frame.points.push_back(values[p]);
      }
    for (const auto &[begin, end] : lines_of(surfaces))
      {
        append(begin, frame.lines);
        append(end, frame.lines);
      }
    frames.push_back(std::move(frame));
  }

  std::string
  Animation::json() const
  {
    std::vector<std::array<double, 2>> ranges, line_ranges;
    for (unsigned int c = 0; c <= dim; ++c)
      ranges.push_back(range(component(frames, &FilmFrame::points, c, dim + 1),
                             c < dim ? 0. : 0.01));
    for (unsigned int c = 0; c < dim; ++c)
      line_ranges.push_back(
        range(component(frames, &FilmFrame::lines, c, dim), 0.));
    nlohmann::json result{{"dim", dim},
                          {"label", label},
                          {"ranges", ranges},
                          {"line_ranges", line_ranges}};
    result["frames"] = nlohmann::json::array();
    for (const FilmFrame &frame : frames)
      result["frames"].push_back(
        {{"time", frame.time},
         {"extremes",
          range(component({frame}, &FilmFrame::points, dim, dim + 1), 0.)},
         {"data", coded(frame.points, ranges)},
         {"lines", coded(frame.lines, line_ranges)}});
    return result.dump();
  }

  template void
  Animation::add<2>(const double,
                    const std::vector<dealii::Point<2>> &,
                    const std::vector<double> &,
                    const std::vector<Surface<2>> &);
  template void
  Animation::add<3>(const double,
                    const std::vector<dealii::Point<3>> &,
                    const std::vector<double> &,
                    const std::vector<Surface<3>> &);
} // namespace emmy
