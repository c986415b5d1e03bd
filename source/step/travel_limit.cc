#include <deal.II/base/mpi.h>

#include <emmy/step/travel_limit.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** Parts that are nearer than this act on one another, in cells. */
    constexpr double reach_of_parts = 2.;
    /** A particle that is nearer than this to a wall feels it, in cells. */
    constexpr double reach_of_walls = 1.;

    constexpr double never = std::numeric_limits<double>::max();

    /** The longest step that two parts allow, s. */
    template <int dim>
    double
    time_of_pair(const typename TravelLimit<dim>::Part &a,
                 const typename TravelLimit<dim>::Part &b,
                 const double                           travel)
    {
      const Tensor<1, dim> e = b.x - a.x, w = a.v - b.v;
      const double         approach = w * e, square = w.norm_square();
      if (!(approach > 0.))
        return never;
      const double distance = e.norm();
      if (distance <= reach_of_parts)
        return travel * distance / approach;
      // |e - w t| = reach
      const double discriminant =
        approach * approach -
        square * (distance * distance - reach_of_parts * reach_of_parts);
      return discriminant < 0.
               ? never
               : std::max((approach - std::sqrt(discriminant)) / square,
                          travel / std::sqrt(square));
    }

    /** Around positions and velocities of parts. */
    template <int dim>
    struct Bounds
    {
      Tensor<1, dim> x_low, x_high, v_low, v_high;

      Bounds() = default;

      explicit Bounds(const typename TravelLimit<dim>::Part &part)
        : x_low(part.x)
        , x_high(part.x)
        , v_low(part.v)
        , v_high(part.v)
      {}

      void
      include(const typename TravelLimit<dim>::Part &part)
      {
        for (unsigned int d = 0; d < dim; ++d)
          {
            x_low[d]  = std::min(x_low[d], part.x[d]);
            x_high[d] = std::max(x_high[d], part.x[d]);
            v_low[d]  = std::min(v_low[d], part.v[d]);
            v_high[d] = std::max(v_high[d], part.v[d]);
          }
      }
    };

    /** Whether no part of one can limit a step because of the other. */
    template <int dim>
    bool
    are_harmless(const Bounds<dim> &a,
                 const Bounds<dim> &b,
                 const double       travel,
                 const double       time_step)
    {
      double square = 0.;
      for (unsigned int d = 0; d < dim; ++d)
        {
          const double a_faster = a.v_high[d] - b.v_low[d],
                       b_faster = b.v_high[d] - a.v_low[d],
                       fastest =
                         std::max(std::abs(a_faster), std::abs(b_faster));
          square += fastest * fastest;
          // the gap, and how fast it closes at most
          const double up   = b.x_low[d] - a.x_high[d] - reach_of_parts,
                       down = a.x_low[d] - b.x_high[d] - reach_of_parts;
          if ((up > 0. && a_faster * time_step <= up) ||
              (down > 0. && b_faster * time_step <= down))
            return true;
        }
      return std::sqrt(square) * time_step <= travel;
    }

    /** A tree of parts: boxes around positions and velocities. */
    template <int dim>
    class Tree
    {
    public:
      using Part = typename TravelLimit<dim>::Part;

      struct Node
      {
        std::size_t  first, last;
        unsigned int children = 0; ///< of the first of two; 0: a leaf
        Bounds<dim>  bounds;

        Node(const std::size_t first, const std::size_t last)
          : first(first)
          , last(last)
        {}
      };

      explicit Tree(const std::vector<Part> &given)
        : parts(given)
      {
        if (!parts.empty())
          {
            nodes.emplace_back(0, parts.size());
            divide(0);
          }
      }

      std::vector<Part> parts;
      std::vector<Node> nodes;

    private:
      void
      divide(const unsigned int n)
      {
        Node &node  = nodes[n];
        node.bounds = Bounds<dim>(parts[node.first]);
        for (std::size_t i = node.first; i < node.last; ++i)
          node.bounds.include(parts[i]);
        const std::size_t first = node.first, last = node.last,
                          middle = (first + last) / 2;
        if (last - first <= 4)
          return;
        const Tensor<1, dim> extent  = node.bounds.x_high - node.bounds.x_low;
        unsigned int         longest = 0;
        for (unsigned int d = 1; d < dim; ++d)
          if (extent[d] > extent[longest])
            longest = d;
        std::nth_element(parts.begin() + first,
                         parts.begin() + middle,
                         parts.begin() + last,
                         [longest](const Part &a, const Part &b) {
                           return a.x[longest] < b.x[longest];
                         });
        const unsigned int child = nodes.size();
        node.children            = child;
        nodes.emplace_back(first, middle); // node is no longer valid
        nodes.emplace_back(middle, last);
        divide(child);
        divide(child + 1);
      }
    };

    /** Goes through those pairs of two trees that could shorten a step. */
    template <int dim>
    class Search
    {
    public:
      Search(const Tree<dim> &own,
             const Tree<dim> &all,
             const double     travel,
             const double     time_step)
        : own(own)
        , all(all)
        , travel(travel)
        , longest(time_step)
      {
        if (!own.nodes.empty() && !all.nodes.empty())
          visit(0, 0);
      }

      double
      result() const
      {
        return longest;
      }

    private:
      void
      visit(const unsigned int a, const unsigned int b)
      {
        const auto &from = own.nodes[a], &to = all.nodes[b];
        if (are_harmless(from.bounds, to.bounds, travel, longest))
          return;
        if (from.children == 0 && to.children == 0)
          {
            for (std::size_t i = from.first; i < from.last; ++i)
              for (std::size_t j = to.first; j < to.last; ++j)
                longest = std::min(longest,
                                   time_of_pair<dim>(own.parts[i],
                                                     all.parts[j],
                                                     travel));
            return;
          }
        const bool splits_own =
          to.children == 0 ||
          (from.children != 0 && from.last - from.first >= to.last - to.first);
        for (const unsigned int child : {0, 1})
          if (splits_own)
            visit(from.children + child, b);
          else
            visit(a, to.children + child);
      }

      const Tree<dim> &own, &all;
      const double     travel;
      double           longest;
    };

    template <int dim>
    std::vector<double>
    packed(const std::vector<typename TravelLimit<dim>::Part> &parts)
    {
      std::vector<double> numbers;
      for (const auto &part : parts)
        for (unsigned int d = 0; d < dim; ++d)
          {
            numbers.push_back(part.x[d]);
            numbers.push_back(part.v[d]);
          }
      return numbers;
    }

    /** Adds the parts of packed(). */
    template <int dim>
    void
    unpack(const std::vector<double>                    &numbers,
           std::vector<typename TravelLimit<dim>::Part> &parts)
    {
      for (std::size_t i = 0; i < numbers.size(); i += 2 * dim)
        {
          parts.emplace_back();
          for (unsigned int d = 0; d < dim; ++d)
            {
              parts.back().x[d] = numbers[i + 2 * d];
              parts.back().v[d] = numbers[i + 2 * d + 1];
            }
        }
    }

    /**
     * Own parts, and those of other ranks that one of them could meet. Each
     * rank knows the bounds of all others, and tells another what may come
     * near these. Collective.
     */
    template <int dim>
    std::vector<typename TravelLimit<dim>::Part>
    those_in_reach(const std::vector<typename TravelLimit<dim>::Part> &own,
                   const double                                        travel,
                   const double   time_step,
                   const MPI_Comm communicator)
    {
      using Part = typename TravelLimit<dim>::Part;
      std::vector<Part> corners; // of the bounds; none without parts
      if (!own.empty())
        {
          Bounds<dim> bounds(own.front());
          for (const Part &part : own)
            bounds.include(part);
          corners = {{bounds.x_low, bounds.v_low},
                     {bounds.x_high, bounds.v_high}};
        }
      const auto of_ranks =
        dealii::Utilities::MPI::all_gather(communicator, packed<dim>(corners));
      std::map<unsigned int, std::vector<double>> told;
      for (unsigned int rank = 0; rank < of_ranks.size(); ++rank)
        {
          if (rank == dealii::Utilities::MPI::this_mpi_process(communicator) ||
              of_ranks[rank].empty())
            continue;
          corners.clear();
          unpack<dim>(of_ranks[rank], corners);
          Bounds<dim> bounds(corners[0]);
          bounds.include(corners[1]);
          std::vector<Part> near;
          for (const Part &part : own)
            if (!are_harmless(Bounds<dim>(part), bounds, travel, time_step))
              near.push_back(part);
          if (!near.empty())
            told[rank] = packed<dim>(near);
        }
      std::vector<Part> result = own;
      for (const auto &[rank, numbers] :
           dealii::Utilities::MPI::some_to_some(communicator, told))
        unpack<dim>(numbers, result);
      return result;
    }
  } // namespace

  template <int dim>
  double
  time_to_meeting(const std::vector<typename TravelLimit<dim>::Part> &own,
                  const std::vector<typename TravelLimit<dim>::Part> &all,
                  const double                                        travel,
                  const double                                        time_step)
  {
    return Search<dim>(Tree<dim>(own), Tree<dim>(all), travel, time_step)
      .result();
  }

  template <int dim>
  TravelLimit<dim>::TravelLimit(
    const double                   travel,
    const BackgroundGrid<dim>     &grid,
    const BoundaryConditions<dim> &boundary_conditions)
    : limit(travel)
    , grid(grid)
    , boundary_conditions(boundary_conditions)
  {}

  template <int dim>
  Tensor<1, dim>
  TravelLimit<dim>::in_cells(const dealii::Point<dim> &position) const
  {
    Tensor<1, dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] = (position[d] - grid.lower_corner()[d]) / grid.cell_size()[d];
    return result;
  }

  template <int dim>
  double
  TravelLimit<dim>::time_to_wall(const Tensor<1, dim> &x,
                                 const Tensor<1, dim> &v) const
  {
    double result = never;
    for (unsigned int d = 0; d < dim; ++d)
      for (const unsigned int end : {0, 1})
        {
          const double gap  = end == 0 ? x[d] : grid.n_cells()[d] - x[d],
                       rate = end == 0 ? -v[d] : v[d];
          if (rate > 0. && boundary_conditions.is_wall(2 * d + end))
            result =
              std::min(result, std::max(limit, gap - reach_of_walls) / rate);
        }
    return result;
  }

  template <int dim>
  std::vector<typename TravelLimit<dim>::Part>
  TravelLimit<dim>::parts(const PointArrays<dim> &points,
                          const unsigned int      velocity_component,
                          const unsigned int      mass_component) const
  {
    std::map<CellKey<dim>, std::pair<double, Part>> sums;
    auto here = sums.end(); // points come cell by cell, most often
    for (std::size_t p = 0; p < points.n_points(); ++p)
      {
        const auto cell = grid.key_of(points.point(p));
        if (here == sums.end() || here->first != cell)
          here = sums.try_emplace(cell).first;
        auto &[mass, part] = here->second;
        const double m     = points.component(mass_component)[p];
        mass += m;
        part.x += m * in_cells(points.point(p));
        part.v += m * points.template get<dim>(velocity_component, p);
      }
    std::vector<Part> result;
    for (const auto &[cell, sum] : sums)
      {
        Part part = sum.second;
        part.x /= sum.first;
        for (unsigned int d = 0; d < dim; ++d)
          part.v[d] /= sum.first * grid.cell_size()[d];
        result.push_back(part);
      }
    return result;
  }

  template <int dim>
  double
  TravelLimit<dim>::operator()(const double            time_step,
                               const PointArrays<dim> &points,
                               const unsigned int      velocity_component,
                               const unsigned int      mass_component) const
  {
    // largest and smallest velocities; one over the time to a wall
    std::vector<double>  extremes(2 * dim + 1,
                                 std::numeric_limits<double>::lowest());
    const Tensor<1, dim> h = grid.cell_size();
    for (std::size_t p = 0; p < points.n_points(); ++p)
      {
        Tensor<1, dim> v = points.template get<dim>(velocity_component, p);
        for (unsigned int d = 0; d < dim; ++d)
          {
            v[d] /= h[d];
            extremes[2 * d]     = std::max(extremes[2 * d], v[d]);
            extremes[2 * d + 1] = std::max(extremes[2 * d + 1], -v[d]);
          }
        if (boundary_conditions.has_walls())
          extremes[2 * dim] =
            std::max(extremes[2 * dim],
                     1. / time_to_wall(in_cells(points.point(p)), v));
      }
    dealii::Utilities::MPI::max(extremes, grid.communicator(), extremes);

    double result = time_step;
    if (extremes[2 * dim] > 0.)
      result = std::min(result, 1. / extremes[2 * dim]);
    double square = 0.;
    for (unsigned int d = 0; d < dim; ++d)
      square += std::pow(extremes[2 * d] + extremes[2 * d + 1], 2);
    if (!(std::sqrt(square) * result > limit))
      return result;

    const std::vector<Part> own =
      parts(points, velocity_component, mass_component);
    return dealii::Utilities::MPI::min(
      time_to_meeting<dim>(
        own,
        those_in_reach<dim>(own, limit, result, grid.communicator()),
        limit,
        result),
      grid.communicator());
  }

#define INSTANTIATE(dim)                                  \
  template class TravelLimit<dim>;                        \
  template double time_to_meeting<dim>(                   \
    const std::vector<typename TravelLimit<dim>::Part> &, \
    const std::vector<typename TravelLimit<dim>::Part> &, \
    const double,                                         \
    const double);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
