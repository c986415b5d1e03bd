// Particle completeness, on which every conservation law rests: sum S = 1,
// sum grad S = 0, sum S x = x_p, sum x (x) grad S = I, for points inside
// cells, on faces, edges and corners of cells and on the edges of the grid,
// and for points a hair outside a wall, which must not be lost; for linear
// functions and for GIMP with domains of any size up to a cell. And the weights
// of GIMP in one direction against the definition, the average of the hat.

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

  unsigned int
  rank()
  {
    return dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  }

  /** All ranks have particles, or, if it is so wanted of several, some have
   * none. */
  void
  check_ranks(const unsigned int n_own_particles,
              const bool         some_shall_have_none,
              const std::string &name)
  {
    const bool is_one =
      dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) == 1;
    const bool all_have_some =
      dealii::Utilities::MPI::min(n_own_particles, MPI_COMM_WORLD) > 0;
    test::check(all_have_some == (is_one || !some_shall_have_none),
                name + "which ranks have particles");
  }

  template <int dim>
  void
  check_completeness(const bool is_gimp, const bool in_first_cells)
  {
    const std::string name = std::to_string(dim) + "D, " +
                             (is_gimp ? "GIMP" : "linear") +
                             (in_first_cells ? ", in the first cells: " : ": ");
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
            const unsigned int n = in_first_cells ? 2 : grid.n_cells()[d];
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
                  x[d] = generator() % 2 ? -1e-18 : n * h * (1. + 2e-16);
              }
          }
        positions.push_back(x);
      }
    // those of all ranks come from the first one
    std::vector<double> values   = layout.initial_values();
    const bool          is_first = rank() == 0;
    for (unsigned int id = 0; is_first && id < positions.size(); ++id)
      {
        const auto cell        = grid.owned_cells().front();
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

    check_ranks(particles.n_locally_owned_particles(), in_first_cells, name);
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
    test::check(dealii::Utilities::MPI::sum(n_seen, MPI_COMM_WORLD) ==
                  positions.size(),
                name + "all points have stencils");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_gimp_weights();
  for (const bool is_gimp : {false, true})
    {
      for (const bool in_first_cells : {false, true})
        {
          check_completeness<2>(is_gimp, in_first_cells);
          check_completeness<3>(is_gimp, in_first_cells);
        }
    }
  return test::report();
}
