// What GIMP leaves out: nodes that would get less than 1e-12 of a particle are
// not active, and all sums stay exact, at any place of a small grid. A place
// beyond the window is an error on all ranks.

#include <emmy/particles/field_layout.h>
#include <emmy/particles/gimp.h>

#include <algorithm>

#include "../check.h"

using namespace emmy;

namespace
{
  /** Five cells a side, 1 x 2 (x 3) m. */
  template <int dim>
  struct FiveCells : public GridParameters<dim>
  {
    FiveCells()
    {
      for (unsigned int d = 0; d < dim; ++d)
        {
          this->cells[d]        = 5;
          this->upper_corner[d] = 5. * (d + 1);
        }
    }
  };

  /** A particle at any place in a small grid, alone: on each rank its own. */
  template <int dim>
  class Alone
  {
  public:
    explicit Alone(const GridParameters<dim> &parameters)
      : grid(parameters, MPI_COMM_SELF)
      , layout(basic_fields(dim))
      , gimp(layout)
      , linear(layout["body"])
      , particles(grid.triangulation(), grid.mapping(), layout.n_components())
    {
      CellKey<dim> middle;
      middle.fill(2);
      particles.insert_particle(grid.corner(middle),
                                dealii::Point<dim>(),
                                0,
                                grid.cell_at(middle));
    }

    Stencils<dim>
    evaluate(const dealii::Point<dim>     &x,
             const dealii::Tensor<1, dim> &l,
             const ShapeFunctions<dim>    &functions)
    {
      Places<dim> places  = linear.places(particles, grid);
      places.positions[0] = x;
      places.cells[0]     = grid.key_of(x);
      places.half_lengths = {l};
      return functions.evaluate(places, grid);
    }

    /** S and h grad S of a node; nothing if it is not reached. */
    std::vector<double>
    weights(const Stencils<dim> &stencils, const CellKey<dim> &node) const
    {
      const auto &group = stencils.groups[0];
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        if (grid.node_key(stencils.node_ids[a]) == node)
          {
            std::vector<double> result{stencils.value(group, a)[0]};
            for (unsigned int d = 0; d < dim; ++d)
              result.push_back(stencils.gradient(group, a, d)[0] *
                               grid.cell_size()[d]);
            return result;
          }
      return {};
    }

    /** All sums; and cells are active that have all their nodes. */
    void
    check_sums(const Stencils<dim>      &stencils,
               const dealii::Point<dim> &x,
               const std::string        &name) const
    {
      const auto            &group = stencils.groups[0];
      double                 sum   = 0.;
      dealii::Tensor<1, dim> slopes, position;
      dealii::Tensor<2, dim> unit;
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          const auto   node = grid.node_position(stencils.node_ids[a]);
          const double S    = stencils.value(group, a)[0];
          sum += S;
          position += S * node;
          for (unsigned int d = 0; d < dim; ++d)
            {
              const double slope = stencils.gradient(group, a, d)[0];
              slopes[d] += slope;
              for (unsigned int e = 0; e < dim; ++e)
                unit[e][d] += slope * node[e];
            }
        }
      for (unsigned int d = 0; d < dim; ++d)
        unit[d][d] -= 1.;
      test::check_close(sum, 1., 1e-14, name + "sum S");
      test::check_close((position - x).norm(), 0., 1e-14, name + "sum S x");
      test::check_close(slopes.norm(), 0., 1e-13, name + "sum grad S");
      test::check_close(unit.norm(), 0., 1e-13, name + "sum x (x) grad S");
      for (const auto &active : stencils.active_cells)
        for (const auto id : grid.node_ids(active.cell))
          test::check(std::find(stencils.node_ids.begin(),
                                stencils.node_ids.end(),
                                id) != stencils.node_ids.end(),
                      name + "an active cell has active nodes");
    }

    const BackgroundGrid<dim>               grid;
    FieldLayout                             layout;
    const GimpShapeFunctions<dim>           gimp;
    const LinearShapeFunctions<dim>         linear;
    dealii::Particles::ParticleHandler<dim> particles;
  };

  /** Boxes of l = h/4 or 0.7 h that end a part of a cell beyond faces. */
  template <int dim>
  void
  check_small_shares()
  {
    dealii::ParameterAcceptor::clear();
    Alone<dim>        alone{FiveCells<dim>()};
    const std::string name = std::to_string(dim) + "D, small shares: ";
    // node 4 of a row lies behind the cells 2 and 3, node 3 behind cell 2
    const auto place = [&](const std::array<double, dim> &beyond,
                           const double                   part,
                           dealii::Tensor<1, dim>        &l) {
      dealii::Point<dim> x;
      for (unsigned int d = 0; d < dim; ++d)
        {
          const double h = alone.grid.cell_size()[d];
          l[d]           = part * h * (1. + 1.5e-8);
          x[d]           = (3. + beyond[d] - part) * h;
        }
      return x;
    };
    for (const double part : {0.25, 0.7})
      {
        dealii::Tensor<1, dim>  l;
        std::array<double, dim> beyond;
        // one direction, the others well within a cell or at the grid's side
        for (const double end : {1e-18, 1e-14, 1e-12, 1e-9, 1e-7, 1e-3})
          for (unsigned int d = 0; d < dim; ++d)
            for (const bool at_side : {false, true})
              {
                beyond.fill(-0.05);
                beyond[d]            = end;
                dealii::Point<dim> x = place(beyond, part, l);
                if (at_side)
                  x[(d + 1) % dim] = 0.1;
                const auto stencils = alone.evaluate(x, l, alone.gimp);
                alone.check_sums(stencils, x, name);
                bool is_reached = false;
                for (const auto id : stencils.node_ids)
                  is_reached = is_reached || alone.grid.node_key(id)[d] == 4;
                test::check(is_reached == (end == 1e-3),
                            name + "a node is active for " +
                              std::to_string(end * 1e9) + "e-9 of a cell");
              }
        // an edge or corner: shares of 1e-20 and 1e-8
        for (unsigned int n = 2; n <= dim; ++n)
          for (const double end : {1e-5, 2e-2})
            {
              beyond.fill(-0.05);
              CellKey<dim> corner, inner;
              corner.fill(3);
              for (unsigned int d = 0; d < n; ++d)
                {
                  beyond[d] = end;
                  corner[d] = 4;
                }
              inner                      = corner;
              inner[0]                   = 3;
              const dealii::Point<dim> x = place(beyond, part, l);
              const auto stencils        = alone.evaluate(x, l, alone.gimp);
              alone.check_sums(stencils, x, name);
              test::check(alone.weights(stencils, corner).empty() ==
                            (end == 1e-5),
                          name + "a corner");
              test::check(alone.weights(stencils, inner).empty() ==
                            (end == 1e-5 && n == 3),
                          name + "beside a corner");
            }
      }
  }

  /**
   * At the cut, values change by a few times the share, slopes by as much as
   * the slope of the node that is left out.
   */
  template <int dim>
  void
  check_small_jump()
  {
    dealii::ParameterAcceptor::clear();
    Alone<dim>             alone{FiveCells<dim>()};
    const std::string      name = std::to_string(dim) + "D, at the cut: ";
    dealii::Tensor<1, dim> l;
    // corners in two directions: the share is (beyond^2 / (4 l h))^2
    for (const unsigned int n : {1u, 2u})
      {
        const double cut = n == 1 ? 1e-6 : 1e-3, aside = n == 1 ? 1e-8 : 1e-10;
        std::array<dealii::Point<dim>, 2> x;
        std::array<Stencils<dim>, 2>      stencils;
        for (const unsigned int side : {0, 1})
          {
            for (unsigned int d = 0; d < dim; ++d)
              {
                const double h = alone.grid.cell_size()[d];
                l[d]           = 0.25 * h * (1. + 1.5e-8);
                x[side][d]     = 2.7 * h;
                if (d < n)
                  x[side][d] =
                    (2.75 + cut * (side == 0 ? 1. - aside : 1. + aside)) * h;
              }
            stencils[side] = alone.evaluate(x[side], l, alone.gimp);
            alone.check_sums(stencils[side], x[side], name);
          }
        test::check(stencils[0].node_ids.size() < stencils[1].node_ids.size(),
                    name + "more nodes beyond it");
        for (const auto id : stencils[1].node_ids)
          {
            const auto node   = alone.grid.node_key(id);
            auto       before = alone.weights(stencils[0], node);
            before.resize(dim + 1, 0.);
            const auto after = alone.weights(stencils[1], node);
            test::check_close(before[0],
                              after[0],
                              4.1e-12 + 4. * aside * cut,
                              name + "S");
            for (unsigned int d = 0; d < dim; ++d)
              test::check_close(before[1 + d],
                                after[1 + d],
                                (n == 1 ? 4.1e-6 : 8.1e-9) + 8. * aside * cut,
                                name + "h grad S");
          }
      }
  }

  /** A place beyond the window: an error that names the particle, on all ranks.
   */
  template <int dim>
  void
  check_unknown_cells()
  {
    dealii::ParameterAcceptor::clear();
    FiveCells<dim> parameters;
    for (unsigned int d = 0; d < dim; ++d)
      {
        parameters.cells[d]        = 1000;
        parameters.upper_corner[d] = 1000.;
      }
    BackgroundGrid<dim> grid(parameters,
                             MPI_COMM_WORLD,
                             BackgroundGrid<dim>::Cells::none);
    CellKey<dim>        home;
    home.fill(2);
    grid.cover({{home, 1}});
    FieldLayout                             layout = basic_fields(dim);
    const GimpShapeFunctions<dim>           gimp(layout);
    const LinearShapeFunctions<dim>         linear(layout["body"]);
    dealii::Particles::ParticleHandler<dim> particles(grid.triangulation(),
                                                      grid.mapping(),
                                                      layout.n_components());
    const auto                              cell = grid.cell_at(home);
    const bool                              is_owner =
      cell.state() == dealii::IteratorState::valid && cell->is_locally_owned();
    if (is_owner)
      particles.insert_particle(grid.corner(home),
                                dealii::Point<dim>(),
                                17,
                                cell);
    Places<dim> places = linear.places(particles, grid);
    if (is_owner)
      {
        for (unsigned int d = 0; d < dim; ++d)
          places.positions[0][d] = 999.5;
        places.cells[0]     = grid.key_of(places.positions[0]);
        places.half_lengths = {dealii::Tensor<1, dim>()};
      }
    for (const ShapeFunctions<dim> *functions :
         {static_cast<const ShapeFunctions<dim> *>(&gimp),
          static_cast<const ShapeFunctions<dim> *>(&linear)})
      test::check_throws_with([&] { functions->evaluate(places, grid); },
                              {"particle 17", "999.5", "its rank"});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_small_shares<2>();
  check_small_shares<3>();
  check_small_jump<2>();
  check_small_jump<3>();
  check_unknown_cells<2>();
  check_unknown_cells<3>();
  return test::report();
}
