// A body stands where the file says: extent, volume, mass and centre of its
// particles, at boxes that lie on the cells' lattice and at any others.

#include <deal.II/base/mpi.h>

#include <emmy/particles/body_measures.h>
#include <emmy/particles/particle_layout.h>

#include <random>

#include "../check.h"

namespace
{
  using namespace emmy;
  using namespace emmy::test;
  using dealii::Point;

  /** One box in a grid whose cells are no cubes. */
  template <int dim>
  struct Filled
  {
    GridParameters<dim>                     grid_parameters;
    std::unique_ptr<BackgroundGrid<dim>>    grid;
    std::vector<Body<dim>>                  bodies;
    FieldLayout                             layout = basic_fields(dim);
    dealii::Particles::ParticleHandler<dim> particles;

    Filled(const Point<dim>  &lower,
           const Point<dim>  &upper,
           const unsigned int n,
           const std::string &particle_layout,
           const std::string &cut_by = "")
    {
      dealii::ParameterAcceptor::clear();
      grid_parameters.cells    = std::vector<unsigned int>(dim, 8);
      grid_parameters.cells[0] = 16;
      for (unsigned int d = 0; d < dim; ++d)
        {
          grid_parameters.lower_corner[d] = -1.;
          grid_parameters.upper_corner[d] = 3.;
        }
      grid =
        std::make_unique<BackgroundGrid<dim>>(grid_parameters, MPI_COMM_WORLD);
      BodyParameters<dim>       parameters("Bodies/b", "box");
      dealii::ParameterHandler &prm = dealii::ParameterAcceptor::prm;
      dealii::ParameterAcceptor::declare_all_parameters();
      prm.enter_subsection("Bodies");
      prm.enter_subsection("b");
      prm.set("Points per direction", static_cast<long>(n));
      prm.set("Particle layout", particle_layout);
      prm.set("Cut by", cut_by);
      prm.enter_subsection("box");
      const auto corner = [](const Point<dim> &x) {
        std::ostringstream text;
        text << std::setprecision(17) << x[0];
        for (unsigned int d = 1; d < dim; ++d)
          text << ", " << x[d];
        return text.str();
      };
      prm.set("Lower corner", corner(lower));
      prm.set("Upper corner", corner(upper));
      prm.leave_subsection();
      prm.leave_subsection();
      prm.leave_subsection();
      dealii::ParameterAcceptor::parse_all_parameters();
      bodies.push_back(make_body<dim>("b", parameters, 0, 7.));
      layout.add({"half_length", Field::Kind::vector, "m", "half", {}});
      particles.initialize(grid->triangulation(),
                           grid->mapping(),
                           layout.n_components());
      fill(bodies, *grid, layout, particles);
    }

    BodyMeasures<dim>
    measures() const
    {
      return measure_bodies(bodies, *grid, layout, particles)[0];
    }

    /** Positions, volumes and half-lengths, in the order of the particles. */
    std::vector<double>
    numbers() const
    {
      std::vector<double> result;
      for (const auto &particle : particles)
        {
          for (unsigned int d = 0; d < dim; ++d)
            {
              result.push_back(particle.get_location()[d]);
              result.push_back(
                particle.get_properties()[layout["half_length"] + d]);
            }
          result.push_back(
            particle.get_properties()[layout["reference_volume"]]);
        }
      return result;
    }

    unsigned int
    n_notes() const
    {
      unsigned int n = 0;
      for (const auto &line : describe_measures(bodies[0], measures(), *grid))
        n += line.compare(0, 5, "note:") == 0;
      return n;
    }
  };

  template <int dim>
  void
  check_exact(const Filled<dim> &filled,
              const Point<dim>  &lower,
              const Point<dim>  &upper,
              const std::string &what)
  {
    const auto found  = filled.measures();
    double     volume = 1.;
    for (unsigned int d = 0; d < dim; ++d)
      {
        volume *= upper[d] - lower[d];
        check_close(found.lower[d], lower[d], 1e-13, what + ", lower");
        check_close(found.upper[d], upper[d], 1e-13, what + ", upper");
        check_close(found.center[d],
                    0.5 * (lower[d] + upper[d]),
                    1e-12,
                    what + ", centre");
      }
    check_close(found.volume, volume, 1e-12 * volume, what + ", volume");
    check_close(found.mass, 7. * volume, 1e-11 * volume, what + ", mass");
    check(filled.n_notes() == 0, what + ": nothing to note");
  }

  template <int dim>
  void
  check_any_box()
  {
    std::mt19937                           generator(3);
    std::uniform_real_distribution<double> unit(0., 1.);
    for (unsigned int trial = 0; trial < 12; ++trial)
      {
        Point<dim> lower, upper;
        for (unsigned int d = 0; d < dim; ++d)
          {
            lower[d] = -1. + 2. * unit(generator);
            upper[d] = lower[d] + 0.05 + 1.9 * unit(generator);
          }
        const unsigned int n = 1 + trial % 3;
        const Filled<dim>  filled(lower, upper, n, "body");
        check_exact(filled,
                    lower,
                    upper,
                    std::to_string(dim) + "D box " + std::to_string(trial));
        // the nearest spacing: no other division is nearer
        const ParticleLayout<dim> lattice(filled.bodies[0], *filled.grid);
        for (unsigned int d = 0; d < dim; ++d)
          {
            const double wanted = filled.grid->cell_size()[d] / n,
                         length = upper[d] - lower[d],
                         off    = std::abs(lattice.spacing()[d] - wanted);
            for (unsigned int parts = 1; parts < 100; ++parts)
              check(std::abs(length / parts - wanted) >= off - 1e-14,
                    "no division is nearer");
          }
      }
  }

  /** On the cells' lattice both layouts are the same to the last bit. */
  template <int dim>
  void
  check_lattice()
  {
    Point<dim> lower, upper;
    for (unsigned int d = 0; d < dim; ++d)
      {
        lower[d] = -0.75 + 0.5 * d;
        upper[d] = lower[d] + 1.75;
      }
    const Filled<dim> body(lower, upper, 4, "body"),
      cells(lower, upper, 4, "cells");
    check(body.numbers() == cells.numbers(), "boxes on the lattice stay");
    check_exact(body, lower, upper, "a box on the lattice");

    for (unsigned int d = 0; d < dim; ++d)
      {
        lower[d] += 0.03;
        upper[d] += 0.03;
      }
    const Filled<dim> shifted(lower, upper, 4, "cells");
    check(shifted.n_notes() == 1, "with cells a shifted box is noted");
  }

  /** A side of the grid cuts the box before it is divided. */
  template <int dim>
  void
  check_cut()
  {
    Point<dim> lower, upper, cut;
    for (unsigned int d = 0; d < dim; ++d)
      {
        lower[d] = -1.93;
        upper[d] = 0.12;
        cut[d]   = -1.;
      }
    const Filled<dim> filled(lower,
                             upper,
                             2,
                             "body",
                             dim == 2 ? "x-min, y-min" : "x-min, y-min, z-min");
    check_exact(filled, cut, upper, "a box that is cut");
  }

  template <int dim>
  void
  check_all()
  {
    check_any_box<dim>();
    check_lattice<dim>();
    check_cut<dim>();
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_all<2>();
  check_all<3>();
  return report();
}
