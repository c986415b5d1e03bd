#include <emmy/particles/particle_layout.h>
#include <emmy/particles/particle_table.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  using dealii::Point;

  namespace
  {
    /** Faces nearer to the cells' lattice than this lie on it; of a box. */
    constexpr double on_lattice = 1e-6;

    /** Into how many parts a length is divided. */
    long
    nearest_division(const double length, const double wanted)
    {
      const long fewer = std::max(1., std::floor(length / wanted));
      return std::abs(length / fewer - wanted) <=
                 std::abs(length / (fewer + 1) - wanted)
               ? fewer
               : fewer + 1;
    }

    template <int dim>
    bool
    lies_on_lattice(const dealii::BoundingBox<dim> &box,
                    const Point<dim>               &corner,
                    const dealii::Tensor<1, dim>   &wanted)
    {
      for (unsigned int d = 0; d < dim; ++d)
        for (const double face : {box.lower_bound(d), box.upper_bound(d)})
          {
            const double place = (face - corner[d]) / wanted[d];
            if (std::abs(place - std::round(place)) > on_lattice)
              return false;
          }
      return true;
    }
  } // namespace

  template <int dim>
  dealii::BoundingBox<dim>
  uncut_box(const Body<dim> &body, const BackgroundGrid<dim> &grid)
  {
    const auto box = body.shape->bounding_box();
    Point<dim> from, to;
    for (unsigned int d = 0; d < dim; ++d)
      {
        from[d] = box.lower_bound(d);
        to[d]   = box.upper_bound(d);
        if (body.cut_by[2 * d])
          from[d] = std::max(from[d], grid.lower_corner()[d]);
        if (body.cut_by[2 * d + 1])
          to[d] = std::min(to[d], grid.upper_corner()[d]);
        to[d] = std::max(from[d], to[d]);
      }
    return dealii::BoundingBox<dim>({from, to});
  }

  template <int dim>
  ParticleLayout<dim>::ParticleLayout(const Body<dim>           &body,
                                      const BackgroundGrid<dim> &grid)
    : body(body)
    , grid(grid)
    , is_of_body(body.divides_box && body.shape->is_box())
  {
    const unsigned int n = body.points_per_direction;
    for (unsigned int d = 0; d < dim; ++d)
      size[d] = grid.cell_size()[d] / n;
    half = 0.5 / n * grid.cell_size();
    if (const auto *const table = body.shape ? body.shape->table() : nullptr)
      for (unsigned int d = 0; d < dim; ++d)
        {
          size[d] =
            std::pow(body.shape->volume() / table->volumes.size(), 1. / dim);
          half[d] = 0.5 * size[d];
        }
    if (!is_of_body)
      return;
    const auto box = uncut_box(body, grid);
    is_of_body     = !lies_on_lattice(box, grid.lower_corner(), size);
    if (!is_of_body)
      return;
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double length = box.side_length(d);
        lower[d]            = box.lower_bound(d);
        counts[d] = length > 0. ? nearest_division(length, size[d]) : 0;
        if (counts[d] > 0)
          size[d] = length / counts[d];
        half[d] = 0.5 * size[d];
      }
  }

  template <int dim>
  std::vector<Point<dim>>
  ParticleLayout<dim>::points_in(const CellKey<dim> &cell) const
  {
    const Point<dim>              from = grid.corner(cell);
    const auto                    box  = body.shape->bounding_box();
    const dealii::Tensor<1, dim> &h    = grid.size_of(cell);
    for (unsigned int d = 0; d < dim; ++d)
      if (from[d] > box.upper_bound(d) || from[d] + h[d] < box.lower_bound(d))
        return {};
    if (const auto *const table = body.shape ? body.shape->table() : nullptr)
      {
        std::vector<Point<dim>> points;
        for (const unsigned int row : rows_in(cell))
          points.push_back(table->positions[row]);
        return points;
      }
    return is_of_body ? points_of_body(cell) : points_of_cell(cell);
  }

  template <int dim>
  const std::vector<unsigned int> &
  ParticleLayout<dim>::rows_in(const CellKey<dim> &cell) const
  {
    const auto &positions = body.shape->table()->positions;
    if (rows.empty())
      for (unsigned int row = 0; row < positions.size(); ++row)
        rows[grid.key_of(positions[row])].push_back(row);
    return rows[cell];
  }

  template <int dim>
  std::vector<Point<dim>>
  ParticleLayout<dim>::points_of_cell(const CellKey<dim> &cell) const
  {
    const Point<dim>              from = grid.corner(cell);
    const dealii::Tensor<1, dim> &h    = grid.size_of(cell);
    const unsigned int            n    = body.points_per_direction;
    std::vector<Point<dim>>       points;
    for (unsigned int k = 0; k < (dim == 3 ? n : 1); ++k)
      for (unsigned int j = 0; j < n; ++j)
        for (unsigned int i = 0; i < n; ++i)
          {
            const std::array<unsigned int, 3> index{{i, j, k}};
            Point<dim>                        center;
            for (unsigned int d = 0; d < dim; ++d)
              center[d] = from[d] + (index[d] + 0.5) / n * h[d];
            if (body.shape->contains(center))
              points.push_back(center);
          }
    return points;
  }

  template <int dim>
  std::array<std::array<long, 2>, dim>
  ParticleLayout<dim>::candidates(const CellKey<dim> &cell) const
  {
    const Point<dim>                     from = grid.corner(cell);
    std::array<std::array<long, 2>, dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      {
        // with one to spare, as the places are rounded
        const double first = (from[d] - lower[d]) / size[d],
                     last  = first + grid.size_of(cell)[d] / size[d];
        result[d][0]       = std::max(0l, std::lround(std::floor(first)) - 1);
        result[d][1] =
          std::min(counts[d] - 1, std::lround(std::ceil(last)) + 1);
      }
    return result;
  }

  template <int dim>
  std::vector<Point<dim>>
  ParticleLayout<dim>::points_of_body(const CellKey<dim> &cell) const
  {
    std::vector<Point<dim>> points;
    const auto              range = candidates(cell);
    for (unsigned int d = 0; d < dim; ++d)
      if (range[d][0] > range[d][1])
        return points;
    std::array<long, dim> index;
    for (unsigned int d = 0; d < dim; ++d)
      index[d] = range[d][0];
    for (unsigned int d = 0; d < dim;)
      {
        Point<dim> center;
        for (unsigned int c = 0; c < dim; ++c)
          center[c] = lower[c] + (index[c] + 0.5) * size[c];
        if (grid.key_of(center) == cell) // each centre is in one cell alone
          points.push_back(center);
        for (d = 0; d < dim && ++index[d] > range[d][1]; ++d)
          index[d] = range[d][0];
      }
    return points;
  }

#define INSTANTIATE(dim)                            \
  template class ParticleLayout<dim>;               \
  template dealii::BoundingBox<dim> uncut_box<dim>( \
    const Body<dim> &, const BackgroundGrid<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
