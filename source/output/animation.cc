#include <deal.II/base/utilities.h>

#include <emmy/output/animation.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace emmy
{
  namespace
  {
    constexpr unsigned int steps = 65535; ///< of a coded number

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
  } // namespace

  Animation::Animation(const unsigned int dim,
                       const std::string &label,
                       Frames            &frames)
    : dim(dim)
    , label(label)
    , frames(frames)
  {}

  template <int spacedim>
  void
  Animation::add(const double                                time,
                 const std::vector<dealii::Point<spacedim>> &positions,
                 const std::vector<double>                  &values)
  {
    std::vector<float> numbers;
    for (std::size_t p = 0; p < positions.size(); ++p)
      {
        for (unsigned int d = 0; d < spacedim; ++d)
          numbers.push_back(positions[p][d]);
        numbers.push_back(values[p]);
      }
    frames.emplace_back(time, std::move(numbers));
  }

  std::string
  Animation::json() const
  {
    std::vector<std::array<double, 2>> ranges;
    for (unsigned int c = 0; c <= dim; ++c)
      {
        std::vector<float> values;
        for (const auto &[time, numbers] : frames)
          for (std::size_t i = c; i < numbers.size(); i += dim + 1)
            values.push_back(numbers[i]);
        ranges.push_back(range(std::move(values), c < dim ? 0. : 0.01));
      }
    nlohmann::json result{{"dim", dim}, {"label", label}, {"ranges", ranges}};
    result["frames"] = nlohmann::json::array();
    for (const auto &[time, numbers] : frames)
      {
        std::vector<unsigned char> bytes;
        std::vector<float>         values;
        for (std::size_t i = 0; i < numbers.size(); ++i)
          {
            const auto  &ends = ranges[i % (dim + 1)];
            const double size = ends[1] - ends[0],
                         part = size > 0. ? (numbers[i] - ends[0]) / size : 0.;
            const unsigned int code =
              std::lround(steps * std::min(1., std::max(0., part)));
            bytes.push_back(code % 256);
            bytes.push_back(code / 256);
            if (i % (dim + 1) == dim)
              values.push_back(numbers[i]);
          }
        result["frames"].push_back(
          {{"time", time},
           {"extremes", range(std::move(values), 0.)},
           {"data", dealii::Utilities::encode_base64(bytes)}});
      }
    return result.dump();
  }

  template void
  Animation::add<2>(const double,
                    const std::vector<dealii::Point<2>> &,
                    const std::vector<double> &);
  template void
  Animation::add<3>(const double,
                    const std::vector<dealii::Point<3>> &,
                    const std::vector<double> &);
} // namespace emmy
