#ifndef emmy_tests_effects_tangent_h
#define emmy_tests_effects_tangent_h

#include <emmy/step/middle_equation.h>

#include <random>

#include "../check.h"
#include "../scene.h"

// The equation of a step has the derivative that it says.
namespace emmy
{
  namespace test
  {
    inline std::mt19937                           random_numbers(7);
    inline std::uniform_real_distribution<double> uniform(-1., 1.);

    /**
     * J du of an equation that is solved, and how r changes along du.
     * @return share in it of what stands beside the matrix
     */
    template <int dim>
    double
    check_tangent(NonlinearEquation    &equation,
                  const GridStart<dim> &start,
                  Vector               &solution,
                  const std::string    &what)
    {
      equation.evaluate(solution, true);
      Vector direction = solution;
      for (auto &entry : direction)
        entry = uniform(random_numbers);
      start.active->constraints().set_zero(direction);
      equation.expand(direction);
      Vector expected = solution;
      equation.system().jacobian.vmult(expected, direction);
      const Vector of_matrix = expected;
      for (const RankOne &term : equation.system().rank_ones)
        expected.add(term.row * direction, term.column);
      Vector beside = expected;
      beside -= of_matrix;
      start.active->constraints().set_zero(expected); // followers have none
      double error = 0.;
      for (const double h : {1e-6, 1e-7})
        {
          Vector step = direction;
          step *= h;
          Vector change = solution;
          for (const int sign : {1, -1})
            {
              equation.take(solution, step);
              check(equation.evaluate(solution, false), what + ": has meaning");
              if (sign == 1)
                change = equation.system().residual;
              else
                change -= equation.system().residual;
              equation.take_back(solution, step);
              equation.evaluate(solution, true);
              step *= -1.;
            }
          change *= 1. / (2. * h);
          change -= expected;
          error = change.l2_norm() / expected.l2_norm();
        }
      at_most(what + ": derivative of the whole step", error, 1e-8);
      return beside.l2_norm() / expected.l2_norm();
    }

    /**
     * Of a step of a scene, 0.04 s.
     * @param what    of the scene, for messages
     * @param n_steps before it
     */
    template <int dim>
    double
    check_tangent_of_start(const std::string &text,
                           const std::string &what    = "start",
                           const unsigned int n_steps = 2)
    {
      const SceneParameters<dim> parameters(
        ParameterFile::from_text(text, "test"));
      Scene<dim> scene(parameters, MPI_COMM_WORLD);
      scene.initial_report();
      for (unsigned int i = 0; i < n_steps; ++i)
        scene.advance();
      const auto stencils =
        scene.shape_functions->evaluate(scene.particles, scene.grid);
      const auto           points = gather(stencils, scene.layout);
      ParticlesToGrid<dim> to_grid(scene.grid,
                                   scene.boundary_conditions,
                                   scene.layout,
                                   scene.mapping);
      scene.balance.classify(stencils, points, scene.grid, nullptr);
      auto &start         = to_grid(stencils,
                            points,
                            scene.balance.couplings(stencils,
                                                    scene.grid,
                                                    scene.boundary_conditions,
                                                    nullptr));
      start.velocity      = start.mean_velocity;
      const auto equation = scene.balance.over(
        {stencils, points, start, scene.state.time, 0.04, nullptr, nullptr});
      Vector u = start.mean_velocity;
      u *= 0.04;
      start.active->constraints().expand(u);
      return check_tangent<dim>(*equation,
                                start,
                                u,
                                std::to_string(dim) + "D, " + what);
    }

    /** The same where places follow. */
    template <int dim>
    double
    check_tangent_of_middle(const std::string &text,
                            const std::string &what    = "middle",
                            const unsigned int n_steps = 2)
    {
      const SceneParameters<dim> parameters(
        ParameterFile::from_text(text, "test"));
      Scene<dim> scene(parameters, MPI_COMM_WORLD);
      scene.initial_report();
      for (unsigned int i = 0; i < n_steps; ++i)
        scene.advance();
      Places<dim> places =
        scene.shape_functions->places(scene.particles, scene.grid);
      const PointArrays<dim> states = gather(places, scene.layout);
      places                        = scene.middle->first(
        std::move(places), states, 0.04, scene.domain_update.get(), scene.grid);
      ParticlesToGrid<dim> to_grid(scene.grid,
                                   scene.boundary_conditions,
                                   scene.layout,
                                   scene.mapping);
      MiddleEquation<dim>  equation({{*scene.shape_functions,
                                      scene.domain_update.get(),
                                      scene.grid,
                                      scene.layout,
                                      scene.mapping},
                                     scene.balance,
                                     scene.boundary_conditions,
                                     to_grid,
                                     scene.state.time,
                                     0.04,
                                     1e-8,
                                     &scene.phases},
                                   std::move(places));
      Vector               u = equation.first_displacement();
      // places settle where u is; they may move 12 times in all
      for (unsigned int i = 0; i < 5; ++i)
        {
          equation.evaluate(u, true);
          Vector none = u;
          none        = 0.;
          equation.take(u, none);
        }
      return check_tangent<dim>(equation,
                                equation.grid_start(),
                                u,
                                std::to_string(dim) + "D, " + what);
    }
  } // namespace test
} // namespace emmy

#endif
