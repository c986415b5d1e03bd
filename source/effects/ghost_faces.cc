#include <emmy/effects/ghost_faces.h>
#include <emmy/system/active_cells.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    template <int dim>
    using ActiveCells = std::map<CellKey<dim>, GhostCell>;

    /** The active cells of each field that this rank owns. Collective. */
    template <int dim>
    std::vector<ActiveCells<dim>>
    owned_cells(const Stencils<dim>                      &stencils,
                const BackgroundGrid<dim>                &grid,
                const std::vector<const Material<dim> *> &material_of_body)
    {
      std::vector<ActiveCells<dim>> cells(grid.fields().size());
      for (const auto &[body, key] : owned_active_cells(stencils, grid))
        {
          const Material<dim> &material = *material_of_body[body];
          cells[grid.fields().of_body(body)][key].include(
            material.density(), material.p_wave_modulus());
        }
      return cells;
    }

    /** Tell the ranks beside this one of its active cells. Collective. */
    template <int dim>
    void
    exchange(const BackgroundGrid<dim> &grid, ActiveCells<dim> &cells)
    {
      using Data = std::array<double, 3>;
      exchange_beside<Data>(
        grid,
        [&](const CellKey<dim> &key) {
          const auto found = cells.find(key);
          return found == cells.end()
                   ? Data{{-1., -1., -1.}}
                   : Data{{found->second.density,
                           found->second.modulus,
                           found->second.is_boundary ? 1. : 0.}};
        },
        [&](const CellKey<dim> &key, const Data &data) {
          if (data[0] >= 0.)
            cells[key] = {data[0], data[1], data[2] > 0.};
        });
    }

    /** Whether an active cell is at the boundary of the body. */
    template <int dim>
    bool
    is_boundary(const CellKey<dim>            &key,
                const ActiveCells<dim>        &cells,
                const BackgroundGrid<dim>     &grid,
                const BoundaryConditions<dim> &boundary_conditions)
    {
      for (unsigned int face = 0; face < 2 * dim; ++face)
        {
          const auto neighbour = grid.neighbour(key, face);
          if (neighbour ? cells.find(*neighbour) == cells.end()
                        : !boundary_conditions.is_wall(face))
            return true;
        }
      return false;
    }
  } // namespace

  template <int dim>
  dealii::FullMatrix<double>
  ghost_matrix(const unsigned int            direction,
               const dealii::Tensor<1, dim> &sides)
  {
    constexpr unsigned int      n = GhostFace<dim>::nodes_per_layer;
    const std::array<double, 3> jump{{1., -2., 1.}};
    dealii::FullMatrix<double>  J(GhostFace<dim>::n_nodes,
                                 GhostFace<dim>::n_nodes);
    for (unsigned int i = 0; i < J.m(); ++i)
      for (unsigned int j = 0; j < J.n(); ++j)
        {
          J(i, j) = sides[direction] / 3. * jump[i / n] * jump[j / n];
          // the mass matrix of the face, direction by direction
          for (unsigned int d = 0, bit = 0; d < dim; ++d)
            if (d != direction)
              {
                const bool is_same =
                  ((i % n) >> bit) % 2 == ((j % n) >> bit) % 2;
                J(i, j) *= sides[d] / 6. * (is_same ? 2. : 1.);
                ++bit;
              }
        }
    return J;
  }

  template <int dim>
  GhostFaces<dim>::GhostFaces(
    const double                       mass_penalty,
    const double                       stiffness_penalty,
    std::vector<const Material<dim> *> material_of_body)
    : mass_penalty(mass_penalty)
    , stiffness_penalty(stiffness_penalty)
    , material_of_body(std::move(material_of_body))
  {}

  template <int dim>
  std::vector<GhostFace<dim>>
  GhostFaces<dim>::operator()(
    const Stencils<dim>           &stencils,
    const BackgroundGrid<dim>     &grid,
    const BoundaryConditions<dim> &boundary_conditions) const
  {
    const std::vector<ActiveCells<dim>> of_fields =
      owned_cells(stencils, grid, material_of_body);
    std::vector<GhostFace<dim>> faces;
    for (unsigned int field = 0; field < of_fields.size(); ++field)
      add_faces(of_fields[field], field, grid, boundary_conditions, faces);
    return faces;
  }

  template <int dim>
  void
  GhostFaces<dim>::add_faces(const ActiveCells<dim>        &owned,
                             const unsigned int             field,
                             const BackgroundGrid<dim>     &grid,
                             const BoundaryConditions<dim> &boundary_conditions,
                             std::vector<GhostFace<dim>>   &faces) const
  {
    ActiveCells<dim> cells = owned;
    // neighbours must be known to find the boundary, and then theirs
    exchange<dim>(grid, cells);
    for (const auto &[key, data] : owned)
      {
        (void)data;
        cells[key].is_boundary =
          is_boundary<dim>(key, cells, grid, boundary_conditions);
      }
    exchange<dim>(grid, cells);

    for (const auto &[key, old_data] : owned)
      for (unsigned int d = 0; d < dim; ++d)
        {
          (void)old_data;
          const auto upper_key = grid.neighbour(key, 2 * d + 1);
          if (!upper_key)
            continue;
          const auto       upper = cells.find(*upper_key);
          const GhostCell &lower = cells[key];
          if (upper == cells.end() ||
              !(lower.is_boundary || upper->second.is_boundary))
            continue;
          GhostFace<dim> face;
          face.direction = d;
          const double h = grid.size_of(key)[d];
          face.mass =
            mass_penalty * std::max(lower.density, upper->second.density);
          face.stiffness = stiffness_penalty / (h * h) *
                           std::max(lower.modulus, upper->second.modulus);
          const auto lower_ids = grid.node_ids(grid.cell_at(key), field),
                     upper_ids = grid.node_ids(grid.cell_at(*upper_key), field);
          for (unsigned int v = 0, low = 0, high = 0; v < lower_ids.size(); ++v)
            if ((v >> d) % 2 == 0)
              face.node_ids[low++] = lower_ids[v];
            else
              {
                constexpr unsigned int n    = GhostFace<dim>::nodes_per_layer;
                face.node_ids[n + high]     = lower_ids[v];
                face.node_ids[2 * n + high] = upper_ids[v];
                ++high;
              }
          faces.push_back(face);
        }
  }

  template dealii::FullMatrix<double>
  ghost_matrix<2>(const unsigned int, const dealii::Tensor<1, 2> &);
  template dealii::FullMatrix<double>
  ghost_matrix<3>(const unsigned int, const dealii::Tensor<1, 3> &);
  template class GhostFaces<2>;
  template class GhostFaces<3>;
} // namespace emmy
