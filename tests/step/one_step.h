#ifndef emmy_tests_step_one_step_h
#define emmy_tests_step_one_step_h

#include <emmy/step/accounts.h>

#include <memory>
#include <string>

#include "cloud.h"

namespace emmy
{
  namespace test
  {
    /** Kinetic energy and momenta of particles, and the sizes of the sums. */
    struct Motion
    {
      double               energy = 0.;
      dealii::Tensor<1, 3> linear, angular;
      double               angular_size = 0.;
    };

    /**
     * One step of a random cloud, made as Stepper makes it, whether or not
     * Newton has converged, and the discrete identities that it must fulfil.
     * Each is a sum of named terms that vanishes to round-off.
     */
    template <int dim>
    class OneStep
    {
    public:
      /**
       * Makes the step.
       * @param n_iterations of Newton; 20 and more: it shall converge
       * @param what the scene, in messages
       */
      OneStep(const CloudOptions &options,
              const PointMapping &mapping,
              const unsigned int  n_iterations,
              const double        dt,
              const std::string  &what);

      /** All that follows. */
      void
      check();

    private:
      void
      solve(const unsigned int n_iterations);

      /** Of grid and particles, with the works and losses in between. */
      void
      check_energies() const;
      /** What lumping, ghosts, walls and mappings take, in closed form. */
      void
      check_losses() const;
      void
      check_map() const;
      /** Linear and angular, of grid and particles. */
      void
      check_momenta();
      /** That followers follow and take no momentum. */
      void
      check_followers();

      void
      vanishes(const double value, const std::string &fact) const;

      /** Without fixed unknowns in the map. */
      bool
      is_free() const;
      /** X v with X = M~ - M. */
      Vector
      X_times(const Vector &v) const;
      Couplings<dim>
      couplings() const;
      double
      ghost_mass_loss() const;
      double
      wall_loss() const;
      /** p - M~ v */
      Vector
      misfit(const Vector &v) const;
      /** What walls take from the grid's velocity: v_m - v_t. */
      Vector
      stopped() const;
      /** v_new - v_m, what particles get. */
      Vector
      change() const;
      /** What particles have that the grid cannot see, J. */
      double
      unresolved() const;
      dealii::Tensor<1, 3>
      total(const Vector &vector) const;
      /** Sum of x_A x a_A; its size goes into J_scale. */
      dealii::Tensor<1, 3>
      moment(const std::vector<double> &x, const Vector &a);

      const CloudOptions options;
      const PointMapping mapping, plain;
      const double       dt;
      const std::string  what;

      Cloud<dim>              cloud;
      const Stencils<dim>     stencils;
      const PointArrays<dim>  points;
      ParticlesToGrid<dim>    particles_to_grid, consistent;
      GridStart<dim>         &start;
      const ActiveGrid<dim>  &active;
      const NodalMatrix<dim> &M; ///< consistent; M~ may have a larger pattern

      std::unique_ptr<StepEquation<dim>> equation;
      bool                               is_converged = false;
      Vector                             u, v_mapped, v_new;
      PointArrays<dim>                   trial;
      StepAccounts                       books;
      Motion                             before, after;

      double              stored  = 0.; ///< and dissipated, J
      double              scale   = 0.; ///< of energies, J
      double              J_scale = 0., force_size = 0.;
      std::vector<double> x_old, x_mid, x_new, local_u; ///< local nodes
    };
  } // namespace test
} // namespace emmy

#endif
