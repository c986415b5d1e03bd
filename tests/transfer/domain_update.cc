// The domains of GIMP follow a uniform deformation as their update says, in
// the middle of the grid and next to its edge: l0 (det F)^(1/dim), l0 F_ii,
// l0 U_ii, and the extent of the moved corners with the volume of F. Without
// deformation they stay, however often a particle is moved. In the middle of
// a step it is the same, with its derivative.

#include <emmy/effects/internal_force.h>
#include <emmy/material/hencky.h>
#include <emmy/math/spectral.h>
#include <emmy/particles/gimp.h>
#include <emmy/transfer/domain_update.h>
#include <emmy/transfer/particles_to_grid.h>

#include "../check.h"

using namespace emmy;
using dealii::Tensor;

namespace
{
  /** sqrt(F^T F), by squaring what comes out. */
  template <int dim>
  Tensor<2, dim>
  stretch(const Tensor<2, dim> &F)
  {
    const auto C = spectral_decomposition<dim>(
      mandel::symmetric_part<dim>(transpose(F) * F, 1.));
    Tensor<2, dim> U;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        for (unsigned int k = 0; k < dim; ++k)
          U[i][j] += std::sqrt(C.values[k]) * C.vectors[i][k] * C.vectors[j][k];
    test::check_close((U * U - transpose(F) * F).norm(), 0., 1e-14, "U U = C");
    return U;
  }

  /**
   * In the middle of a step with displacement gradient L (at that place) the
   * rule sees F = (I - L/2)^-1 F_old, and its derivative is that of
   * differences.
   */
  template <int dim>
  void
  check_middle(const std::string       &name,
               const DomainUpdate<dim> &update,
               const Tensor<2, dim>    &F_old,
               const Tensor<1, dim>    &initial,
               const PointArrays<dim>  &states)
  {
    const Tensor<2, dim> I = dealii::unit_symmetric_tensor<dim>();
    Tensor<2, dim>       L;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        L[i][j] = 0.1 * std::sin(1. + 3. * i + 5. * j);
    const auto middle = [&](const Tensor<2, dim> &L) {
      return update.middle(states, 0, 0, invert(I - 0.5 * L));
    };
    const MiddleBox<dim> box = middle(L);
    const Tensor<2, dim> F   = invert(I - 0.5 * L) * F_old;
    const auto           U   = stretch<dim>(F);
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double by_rule = name == "detF"
                                 ? std::pow(determinant(F), 1. / dim)
                               : name == "diagF" ? F[d][d]
                                                 : U[d][d];
        test::check_close(box.half_length[d],
                          initial[d] * by_rule,
                          1e-14,
                          name + ": half-length in the middle");
      }
    const double step = 1e-5;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        {
          Tensor<2, dim> less = L, more = L;
          less[i][j] -= step;
          more[i][j] += step;
          const auto difference =
            (middle(more).half_length - middle(less).half_length) / (2. * step);
          for (unsigned int d = 0; d < dim; ++d)
            test::check_close(box.by_L[d][i][j],
                              difference[d],
                              1e-10,
                              name + ": its derivative");
        }
  }

  /** Half-lengths after a step with x -> x + (F - I)(x - center). */
  template <int dim>
  Tensor<1, dim>
  updated(const std::string    &name,
          const Tensor<2, dim> &F,
          const double          distance_from_edge,
          Tensor<1, dim>       &initial)
  {
    dealii::ParameterAcceptor::clear();
    GridParameters<dim> parameters;
    for (unsigned int d = 0; d < dim; ++d)
      {
        parameters.cells[d]        = 6;
        parameters.upper_corner[d] = 3. + d;
      }
    const BackgroundGrid<dim>     grid(parameters, MPI_COMM_WORLD);
    const BoundaryParameters      boundary;
    const BoundaryConditions<dim> free(boundary, grid);

    ElasticConstants constants;
    constants.density       = 1.;
    constants.young_modulus = 1.;
    constants.poisson_ratio = 0.;
    const Hencky<dim>        material(constants.completed("test"));
    FieldLayout              layout = basic_fields(dim);
    const InternalForce<dim> force({&material},
                                   layout,
                                   stress_rule<dim>("conserving"));
    GimpShapeFunctions<dim>  shape_functions(layout);

    std::vector<Body<dim>> bodies(1);
    bodies[0].points_per_direction = 2;
    bodies[0].divides_box          = false;
    initial                        = initial_half_length(bodies[0], grid);
    const auto update = make_domain_update<dim>(name, bodies, grid, layout);

    dealii::Particles::ParticleHandler<dim> particles(grid.triangulation(),
                                                      grid.mapping(),
                                                      layout.n_components());
    dealii::Point<dim>                      x;
    std::vector<double>                     values = layout.initial_values();
    values[layout["mass"]]                         = 1.;
    for (unsigned int d = 0; d < dim; ++d)
      {
        x[d] = d == 0 ? distance_from_edge : 1.3 + 0.1 * d;
        values[layout["half_length"] + d] = initial[d];
      }
    // of several ranks the others have no particle, but their part in all that
    const auto cell = grid.cell_at(grid.key_of(x));
    const bool is_owner =
      cell.state() == dealii::IteratorState::valid && cell->is_locally_owned();
    test::check(dealii::Utilities::MPI::sum(is_owner ? 1 : 0, MPI_COMM_WORLD) ==
                  1,
                "one rank has the particle");
    if (is_owner)
      particles.insert_particle(x,
                                dealii::Point<dim>(),
                                0,
                                cell,
                                dealii::ArrayView<const double>(values.data(),
                                                                values.size()));
    particles.update_cached_numbers();

    const auto           stencils = shape_functions.evaluate(particles, grid);
    const auto           points   = gather(stencils, layout);
    PointMapping         mapping;
    ParticlesToGrid<dim> map(grid, free, layout, mapping);
    const auto          &active = *map(stencils, points).active;
    std::vector<double>  u(dim * active.n_local_nodes());
    const auto           I = dealii::unit_symmetric_tensor<dim>();
    for (unsigned int node = 0; node < active.n_local_nodes(); ++node)
      {
        const Tensor<1, dim> motion = (F - I) * (active.position(node) - x);
        for (unsigned int d = 0; d < dim; ++d)
          u[dim * node + d] = motion[d];
      }
    PointArrays<dim> trial = points;
    if (is_owner)
      trial.set(layout["left_cauchy_green_less_unit"],
                0,
                mandel::symmetric_part<dim>(F * transpose(F), 1.) -
                  mandel::unit<dim>());
    (*update)(stencils, points, active, u, trial);
    if (is_owner && name != "corners")
      check_middle(name, *update, F, initial, trial);
    Tensor<1, dim> half_length;
    if (is_owner)
      half_length = trial.template get<dim>(layout["half_length"], 0);
    return dealii::Utilities::MPI::sum(half_length, MPI_COMM_WORLD);
  }

  template <int dim>
  void
  check_all()
  {
    Tensor<2, dim> I = dealii::unit_symmetric_tensor<dim>(), sheared = I,
                   turned = I, bent;
    sheared[0][1]         = 0.3;
    sheared[dim - 1][0]   = -0.1;
    sheared[1][1]         = 1.2;
    turned[0][0] = turned[1][1] = std::cos(0.4);
    turned[0][1]                = -std::sin(0.4);
    turned[1][0]                = std::sin(0.4);
    bent                        = turned * sheared;

    // in the middle of a cell; with a domain that is clipped at the edge
    for (const double distance : {1.26, 0.07})
      for (const auto &F : {I, sheared, turned, bent})
        {
          const std::string where =
            std::to_string(dim) + "D, at " + std::to_string(distance) + " m, ";
          const double   J = determinant(F);
          const auto     U = stretch<dim>(F);
          Tensor<1, dim> l0;
          const auto     check = [&](const std::string    &name,
                                 const Tensor<1, dim> &l,
                                 const Tensor<1, dim> &expected) {
            test::check_close((l - expected).norm(),
                              0.,
                              1e-14,
                              where + name + ": half-lengths");
          };
          const auto     detF    = updated<dim>("detF", F, distance, l0);
          const auto     diagF   = updated<dim>("diagF", F, distance, l0);
          const auto     stretch = updated<dim>("stretch", F, distance, l0);
          const auto     corners = updated<dim>("corners", F, distance, l0);
          Tensor<1, dim> by_diagonal, by_stretch, extent;
          double         scale = J;
          for (unsigned int d = 0; d < dim; ++d)
            {
              by_diagonal[d] = l0[d] * F[d][d];
              by_stretch[d]  = l0[d] * U[d][d];
              for (unsigned int e = 0; e < dim; ++e)
                extent[d] += std::abs(F[d][e]) * l0[e];
              scale *= l0[d] / extent[d];
            }
          check("detF", detF, std::pow(J, 1. / dim) * l0);
          check("diagF", diagF, by_diagonal);
          check("stretch", stretch, by_stretch);
          // beyond the edge there is no motion: there only without deformation
          if (distance > l0[0])
            check("corners", corners, std::pow(scale, 1. / dim) * extent);
          if (F == I)
            check("corners at rest", corners, l0);
        }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_all<2>();
  check_all<3>();
  return test::report();
}
