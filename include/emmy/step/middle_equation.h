#ifndef emmy_step_middle_equation_h
#define emmy_step_middle_equation_h

#include <emmy/effects/moving_places.h>
#include <emmy/step/step_equation.h>

namespace emmy
{
  /**
   * The balance of a step whose grid is undeformed in its middle: all of the
   * step, shape functions, mass, momentum, loads and force, is of the places
   * and boxes that the particles have at t + dt/2 (derived in doc/method.md).
   * These places are unknowns too. Newton sees the nodes only; here the places
   * follow each of its increments, and mass, momentum and numbering are made
   * anew there. What is exact for the energy and for linear momentum is so at
   * any places; angular momentum is when they have settled.
   *
   * Made by the step for each attempt. Cost of an evaluation: that of a
   * StepEquation, and of stencils, mass and momentum.
   */
  template <int dim>
  class MiddleEquation : public NonlinearEquation
  {
  public:
    /** What an attempt starts from. */
    struct Start
    {
      PlaceRules<dim>                rules;               ///< how places move
      const Balance<dim>            &balance;             ///< all forces
      const BoundaryConditions<dim> &boundary_conditions; ///< of the scene
      /** Made anew at each place. */
      ParticlesToGrid<dim> &particles_to_grid;
      /** Start and size of the step, s. */
      double  time, time_step;
      double  tolerance; ///< of places, in cells
      Phases *phases;    ///< where the time goes
    };

    /**
     * @param guess the first places, of particles in their states at t, which
     *   stay as they are. Collective.
     */
    MiddleEquation(Start start, Places<dim> guess);

    /** Where Newton starts, numbered as the unknowns are now. Collective. */
    Vector
    first_displacement() const;

    bool
    evaluate(const Vector &solution, const bool with_jacobian) override;
    NewtonSystem
    system() override;
    void
    expand(Vector &increment) const override;
    double
    size(const Vector &increment) const override;
    bool
    has_kinks() const override
    {
      return step_equation->has_kinks();
    }
    void
    take(Vector &solution, Vector &increment) override;
    void
    halve(Vector &solution, Vector &increment) override;
    void
    take_back(Vector &solution, Vector &increment) override;
    bool
    is_settled() const override;
    /** Without moving the places any more. */
    void
    begin_again(Vector &solution, const Vector &first) override;
    const std::string &
    problem() const override;

    /** Whether the places stopped to move before they had settled. */
    bool
    has_given_up() const;
    /** The largest distance of a place from the middle of its step, cells. */
    double
    largest_defect() const;

    /**
     * What the step leaves of the particles' angular momentum without a cause:
     * sum m (x_mid - x) x dv, kg m^2/s. Collective.
     * @param trial states at t + dt
     */
    dealii::Tensor<1, 3>
    angular_momentum_left(const Vector           &displacement,
                          const PointArrays<dim> &trial) const;

    /** At the latest places. */
    const Ground<dim> &
    ground() const;
    /** Mass and momentum at the places; the velocity is left to the caller. */
    GridStart<dim> &
    grid_start();
    /** At the latest places. */
    StepEquation<dim> &
    equation();

  private:
    /** Make the ground at the places, and number the vectors anew. */
    void
    renew(Places<dim> new_places, Vector *solution, Vector *increment);
    /** The nodes of the ground that is next, where not as before; momentum. */
    void
    renew_nodes(const Ground<dim> &next);
    /** What is wrong with places: boxes reach cells that this rank misses. */
    std::string
    problem_of(const Places<dim> &places) const;

    const Start                            start;
    const Places<dim>                      first_places;
    Places<dim>                            places, places_before;
    std::unique_ptr<Ground<dim>>           current;
    std::shared_ptr<const ActiveGrid<dim>> active;
    GridStart<dim>                        *on_grid = nullptr;
    std::unique_ptr<MovingPlaces<dim>>     moving;
    std::unique_ptr<StepEquation<dim>>     step_equation;
    unsigned int                           n_moves   = 0;
    bool                                   is_frozen = false;
    double                                 defect    = 0.;
    std::string                            found;
  };
} // namespace emmy

#endif
