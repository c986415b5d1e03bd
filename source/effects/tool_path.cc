#include <emmy/effects/tool_path.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace emmy
{
  using dealii::Point;

  namespace
  {
    /** In how many instants a run is looked at, but for its start. */
    constexpr unsigned int n_instants = 50;
    /** Cells of the lattice along the longest side of the grid. */
    constexpr double n_lattice = 20.;

    /** Points of a box, and how far the farthest point of it is from them. */
    template <int dim>
    std::pair<std::vector<Point<dim>>, double>
    lattice_of(const Point<dim> &lower, const Point<dim> &upper)
    {
      const dealii::Tensor<1, dim> size    = upper - lower;
      double                       longest = 0., square = 0.;
      for (unsigned int d = 0; d < dim; ++d)
        longest = std::max(longest, size[d]);
      std::vector<Point<dim>> points{lower};
      for (unsigned int d = 0; d < dim; ++d)
        {
          const unsigned int n = std::ceil(n_lattice * size[d] / longest);
          const double       h = size[d] / n;
          square += 0.25 * h * h;
          const std::size_t n_before = points.size();
          for (unsigned int i = 1; i <= n; ++i)
            for (std::size_t p = 0; p < n_before; ++p)
              {
                points.push_back(points[p]);
                points.back()[d] += i * h;
              }
        }
      return {std::move(points), std::sqrt(square)};
    }
  } // namespace

  template <int dim>
  ToolPath<dim>::ToolPath(const ToolShape<dim>  &shape,
                          const ToolMotion<dim> &motion,
                          const double           end_time)
    : shape(shape)
  {
    for (unsigned int i = 0; i <= n_instants; ++i)
      {
        const double time = end_time * i / n_instants;
        instants.push_back(
          {time, motion.place(time), transpose(motion.directions(time))});
      }
  }

  template <int dim>
  double
  ToolPath<dim>::distance(const Instant &instant, const Point<dim> &point) const
  {
    return shape.distance(instant.to_frame * (point - instant.place)).value;
  }

  template <int dim>
  double
  ToolPath<dim>::way(const Instant &from, const Instant &to, const double reach)
  {
    return from.place.distance(to.place) +
           (to.to_frame - from.to_frame).norm() * reach;
  }

  template <int dim>
  bool
  ToolPath<dim>::moves() const
  {
    return std::any_of(instants.begin(),
                       instants.end(),
                       [this](const Instant &instant) {
                         return way(instants.front(), instant, 1.) > 0.;
                       });
  }

  template <int dim>
  double
  ToolPath<dim>::least_gap(const std::vector<Point<dim>> &points) const
  {
    double least = std::numeric_limits<double>::max();
    if (points.empty())
      return least;
    double                   farthest = 0.;
    dealii::BoundingBox<dim> box(points);
    for (const Instant &instant : instants)
      for (unsigned int v = 0; v < (1u << dim); ++v)
        farthest = std::max(farthest, instant.place.distance(box.vertex(v)));
    // how far the tool was from all points, and when
    double         gap     = 0.;
    const Instant *seen    = nullptr;
    double         between = 0.;
    for (const Instant &instant : instants)
      {
        if (&instant != &instants.front())
          between = std::max(between, way(*(&instant - 1), instant, farthest));
        if (seen && gap - way(*seen, instant, farthest) >= least)
          continue;
        gap = std::numeric_limits<double>::max();
        for (const Point<dim> &point : points)
          if (shape.least_distance(instant.to_frame * (point - instant.place)) <
              gap)
            gap = std::min(gap, distance(instant, point));
        seen  = &instant;
        least = std::min(least, gap);
      }
    return std::max(0., least - 0.5 * between);
  }

  template <int dim>
  bool
  ToolPath<dim>::is_outside(const Instant                 &instant,
                            const std::vector<Point<dim>> &lattice,
                            const double                   spacing) const
  {
    return std::all_of(lattice.begin(),
                       lattice.end(),
                       [&](const Point<dim> &point) {
                         return distance(instant, point) > spacing;
                       });
  }

  template <int dim>
  std::optional<double>
  ToolPath<dim>::outside_since(const Point<dim> &lower,
                               const Point<dim> &upper) const
  {
    const auto [lattice, spacing] = lattice_of(lower, upper);
    std::optional<double> since;
    for (auto it = instants.rbegin();
         it != instants.rend() && is_outside(*it, lattice, spacing);
         ++it)
      since = it->time;
    return since;
  }

  template class ToolPath<2>;
  template class ToolPath<3>;
} // namespace emmy
