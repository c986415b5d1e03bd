// Particle completeness, on which every conservation law rests: sum S = 1,
// sum grad S = 0, sum S x = x_p, sum x (x) grad S = I, for points inside
// cells, on faces, edges and corners of cells and on the edges of the grid,
// and for points a hair outside a wall, which must not be lost; for linear
// functions and for GIMP with domains of any size up to a cell. And the weights
// of GIMP in one direction against the definition, the average of the hat.
// Nodes that would get less than 1e-12 of a particle are not active.

#include <deal.II/base/quadrature_lib.h>

#include <emmy/particles/field_layout.h>
#include <emmy/particles/gimp.h>
#include <emmy/transfer/particle_sort.h>

#include <algorithm>
#include <random>

#include "../check.h"

using namespace emmy;

namespace
{
  /** The average of the hat over [d - l, d + l], cut where it has a kink. */
  double
  averaged_hat(const double d, const double l, const double h)
  {
    const dealii::QGauss<1> gauss(2); // exact for linear functions
    std::vector<double>     ends{d - l, d + l};
    for (const double kink : {-h, 0., h})
      if (kink > d - l && kink < d + l)
        ends.push_back(kink);
    std::sort(ends.begin(), ends.end());
    double sum = 0.;
    for (unsigned int i = 0; i + 1 < ends.size(); ++i)
      for (unsigned int q = 0; q < gauss.size(); ++q)
        {
          const double y =
            ends[i] + gauss.point(q)[0] * (ends[i + 1] - ends[i]);
          sum += gauss.weight(q) * (ends[i + 1] - ends[i]) *
                 std::max(0., 1. - std::abs(y) / h);
        }
    return sum / (2. * l);
  }

  void
  check_gimp_weights()
  {
    std::mt19937                           generator(5);
    std::uniform_real_distribution<double> unit(0., 1.);
    const double                           h = 0.7;
    for (unsigned int sample = 0; sample < 300; ++sample)
      {
        // 0 ... 2.5 h, some of them tiny, some exactly h/2 and h
        const double l   = sample % 10 == 0   ? 0.5 * h
                           : sample % 10 == 1 ? h
                           : sample % 10 == 2 ? 1e-4 * unit(generator) * h
                                              : 2.5 * unit(generator) * h;
        const double x   = sample % 7 == 0 ? 0.3 * h : unit(generator) * h;
        double       sum = 0., slopes = 0., position = 0., unit_slope = 0.;
        // the cells that the domain overlaps, counted from that of x
        const int first = std::floor((x - l) / h),
                  last  = std::ceil((x + l) / h) - 1;
        std::vector<Weight> weights(last - first + 2);
        gimp_weights(x - first * h, l, h, last - first + 1, weights.data());
        for (int node = first; node <= last + 1; ++node)
          {
            const Weight w = weights[node - first];
            const double d = x - node * h;
            test::check_close(w.value,
                              averaged_hat(d, l, h),
                              1e-15 + 1e-15 * h / l,
                              "GIMP: the average of the hat");
            const double hats = std::max(0., 1. - std::abs(d + l) / h) -
                                std::max(0., 1. - std::abs(d - l) / h);
            test::check_close(w.slope * h,
                              hats / (2. * l) * h,
                              1e-14 + 1e-15 * h / l,
                              "GIMP: the slope of the average");
            sum += w.value;
            slopes += w.slope;
            position += w.value * node * h;
            unit_slope += w.slope * node * h;
          }
        test::check_close(sum, 1., 1e-14, "GIMP: sum S");
        test::check_close(slopes, 0., 1e-13, "GIMP: sum S'");
        test::check_close(position, x, 1e-14, "GIMP: sum S x");
        test::check_close(unit_slope, 1., 1e-13, "GIMP: sum S' x");
      }
  }

  template <int dim>
  void
  check_completeness(const bool is_gimp)
  {
    const std::string name =
      std::to_string(dim) + "D, " + (is_gimp ? "GIMP: " : "linear: ");
    dealii::ParameterAcceptor::clear();
    GridParameters<dim> parameters;
    for (unsigned int d = 0; d < dim; ++d)
      {
        parameters.cells[d]        = 2 * (d + 2);
        parameters.upper_corner[d] = 1. + 0.3 * d;
      }
    BackgroundGrid<dim>                  grid(parameters, MPI_COMM_WORLD);
    FieldLayout                          layout = basic_fields(dim);
    std::unique_ptr<ShapeFunctions<dim>> shape_functions;
    if (is_gimp)
      shape_functions = std::make_unique<GimpShapeFunctions<dim>>(layout);
    else
      shape_functions =
        std::make_unique<LinearShapeFunctions<dim>>(layout["body"]);
    dealii::Particles::ParticleHandler<dim> particles(grid.triangulation(),
                                                      grid.mapping(),
                                                      layout.n_components());

    // all points start at the centre of a cell and are moved, as in a run
    std::mt19937                           generator(3);
    std::uniform_real_distribution<double> unit(0., 1.);
    std::vector<dealii::Point<dim>>        positions;
    for (unsigned int kind = 0; kind < 400; ++kind)
      {
        dealii::Point<dim> x;
        for (unsigned int d = 0; d < dim; ++d)
          {
            const double       h = grid.cell_size()[d];
            const unsigned int n = grid.n_cells()[d];
            switch ((kind + generator()) % 4)
              {
                case 0: // inside
                  x[d] = unit(generator) * n * h;
                  break;
                case 1: // on a face of cells, the grid's edges among them
                  x[d] = (generator() % (n + 1)) * h;
                  break;
                case 2: // next to a face, by round-off
                  x[d] =
                    std::min(n * h, (generator() % (n + 1)) * h * (1. + 1e-16));
                  break;
                default: // a hair outside a wall
                  x[d] = generator() % 2
                           ? -1e-18
                           : parameters.upper_corner[d] * (1. + 2e-16);
              }
          }
        positions.push_back(x);
      }
    const auto          cell   = grid.triangulation().begin_active();
    std::vector<double> values = layout.initial_values();
    for (unsigned int id = 0; id < positions.size(); ++id)
      {
        values[layout["body"]] = id % 3;
        // up to a whole cell and beyond, where it is cut; some so small that
        // the particle is a point
        if (is_gimp)
          for (unsigned int d = 0; d < dim; ++d)
            values[layout["half_length"] + d] =
              grid.cell_size()[d] * (id % 5 == 0   ? 1e-8
                                     : id % 5 == 1 ? 1.
                                     : id % 5 == 2 ? 1.7
                                                   : unit(generator));
        particles.insert_particle(
          cell->center(),
          dealii::Point<dim>(),
          id,
          cell,
          dealii::ArrayView<const double>(values.data(), values.size()));
      }
    particles.update_cached_numbers();
    for (auto &particle : particles)
      particle.set_location(positions[particle.get_id()]);
    sort_into_cells(grid, particles);
    test::check(particles.n_global_particles() == positions.size(),
                name + "no particle is lost");

    const auto   stencils = shape_functions->evaluate(particles, grid);
    unsigned int n_seen   = 0;
    for (const auto &group : stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          ++n_seen;
          const auto &particle = *stencils.particles[group.first_point + q];
          test::check(particle.get_properties()[layout["body"]] == group.body,
                      name + "a group is of one body");
          double                 sum = 0.;
          dealii::Tensor<1, dim> gradient_sum, position;
          dealii::Tensor<2, dim> unit_tensor;
          bool                   is_positive = true;
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            {
              const auto &node =
                grid.node_position(stencils.node_ids[group.first_node + a]);
              const double S = stencils.value(group, a)[q];
              is_positive    = is_positive && S > -1e-12;
              sum += S;
              position += S * node;
              for (unsigned int d = 0; d < dim; ++d)
                {
                  const double slope = stencils.gradient(group, a, d)[q];
                  gradient_sum[d] += slope;
                  for (unsigned int e = 0; e < dim; ++e)
                    unit_tensor[e][d] += node[e] * slope;
                }
            }
          for (unsigned int d = 0; d < dim; ++d)
            unit_tensor[d][d] -= 1.;
          test::check(is_positive, name + "S is not negative");
          test::check_close(sum, 1., 1e-14, name + "sum S");
          test::check_close(particle.get_location().distance(
                              positions[particle.get_id()]),
                            0.,
                            1e-15,
                            name + "positions stay, to round-off");
          test::check_close((position - particle.get_location()).norm(),
                            0.,
                            1e-14,
                            name + "sum S x");
          test::check_close(gradient_sum.norm(),
                            0.,
                            1e-13,
                            name + "sum grad S");
          test::check_close(unit_tensor.norm(),
                            0.,
                            1e-13,
                            name + "sum x (x) grad S");
        }
    test::check(n_seen == positions.size(), name + "all points have stencils");
  }
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

  /** A particle at any place in a small grid, alone. */
  template <int dim>
  class Alone
  {
  public:
    explicit Alone(const GridParameters<dim> &parameters)
      : grid(parameters, MPI_COMM_WORLD)
      , layout(basic_fields(dim))
      , gimp(layout)
      , linear(layout["body"])
      , particles(grid.triangulation(), grid.mapping(), layout.n_components())
    {
      typename BackgroundGrid<dim>::Lattice middle;
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
      places.cells[0]     = grid.lattice(x);
      places.half_lengths = {l};
      return functions.evaluate(places, grid);
    }

    /** S and h grad S of a node; nothing if it is not reached. */
    std::vector<double>
    weights(const Stencils<dim>                         &stencils,
            const typename BackgroundGrid<dim>::Lattice &node) const
    {
      const auto &group = stencils.groups[0];
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        if (grid.node_lattice(stencils.node_ids[a]) == node)
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
      for (const auto &cell : stencils.active_cells)
        for (const auto id : grid.node_ids(cell))
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
                  is_reached =
                    is_reached || alone.grid.node_lattice(id)[d] == 4;
                test::check(is_reached == (end == 1e-3),
                            name + "a node is active for " +
                              std::to_string(end * 1e9) + "e-9 of a cell");
              }
        // an edge or corner: shares of 1e-20 and 1e-8
        for (unsigned int n = 2; n <= dim; ++n)
          for (const double end : {1e-5, 2e-2})
            {
              beyond.fill(-0.05);
              typename BackgroundGrid<dim>::Lattice corner, inner;
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
            const auto node   = alone.grid.node_lattice(id);
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

  /** A place beyond the window: an error that names the particle. */
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
    BackgroundGrid<dim>                   grid(parameters,
                             MPI_COMM_WORLD,
                             BackgroundGrid<dim>::Cells::none);
    typename BackgroundGrid<dim>::Lattice home;
    home.fill(2);
    grid.cover({{home, 1}});
    FieldLayout                             layout = basic_fields(dim);
    const GimpShapeFunctions<dim>           gimp(layout);
    const LinearShapeFunctions<dim>         linear(layout["body"]);
    dealii::Particles::ParticleHandler<dim> particles(grid.triangulation(),
                                                      grid.mapping(),
                                                      layout.n_components());
    particles.insert_particle(grid.corner(home),
                              dealii::Point<dim>(),
                              17,
                              grid.cell_at(home));
    Places<dim> places = linear.places(particles, grid);
    for (unsigned int d = 0; d < dim; ++d)
      places.positions[0][d] = 999.5;
    places.cells[0]     = grid.lattice(places.positions[0]);
    places.half_lengths = {dealii::Tensor<1, dim>()};
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
  check_gimp_weights();
  for (const bool is_gimp : {false, true})
    {
      check_completeness<2>(is_gimp);
      check_completeness<3>(is_gimp);
    }
  check_small_shares<2>();
  check_small_shares<3>();
  check_small_jump<2>();
  check_small_jump<3>();
  check_unknown_cells<2>();
  check_unknown_cells<3>();
  return test::report();
}
