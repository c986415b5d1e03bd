#ifndef emmy_run_scene_h
#define emmy_run_scene_h

#include <emmy/effects/explicit_force.h>
#include <emmy/output/particle_fields.h>
#include <emmy/run/scene_parameters.h>
#include <emmy/step/time_integrator.h>

#include <iosfwd>

namespace emmy
{
  struct SceneCard;

  /** What the price of a material is booked to. */
  inline std::string
  material_effect(const std::string &name_of_material)
  {
    return "material " + name_of_material;
  }

  /**
   * A scene, ready to run: what the parameters describe, built in the order
   * in which one thing needs the other. It only holds things together; each
   * of them knows just what it was given.
   */
  template <int dim>
  class Scene
  {
  public:
    /**
     * Build, fill with particles, and distribute over the ranks. Collective.
     * Throws ExcParameter or ExcRun on all ranks.
     */
    Scene(const SceneParameters<dim> &parameters, const MPI_Comm communicator);

    /** The state before the first step, as row 0 of the ledger. Collective. */
    StepReport
    initial_report();

    /** One step, and what the scene measures after it: see Stepper. */
    StepReport
    advance();

    /**
     * The scene in words: what is there and what it will cost. Collective.
     * @param with_absent whether the card has what is absent too
     */
    void
    describe(std::ostream     &out,
             const StepReport &initial,
             const SceneCard  &card,
             const bool        with_absent) const;

    /** Where the time goes. */
    Phases phases;
    /** Where steps are solved. */
    BackgroundGrid<dim> grid;
    /** Sides and held parts. */
    BoundaryConditions<dim> boundary_conditions;
    /** By name of the parameter file. */
    std::vector<std::unique_ptr<Material<dim>>> materials;
    /** In the order of their names. */
    std::vector<Body<dim>> bodies;
    /** Borrowed from materials, one per body. */
    std::vector<const Material<dim> *> material_of_body;
    FieldLayout                        layout; ///< what particles carry
    /** Of explicit steps; null with implicit ones. */
    std::unique_ptr<ExplicitForce<dim>>  explicit_force;
    Balance<dim>                         balance;         ///< all forces
    std::unique_ptr<ShapeFunctions<dim>> shape_functions; ///< GIMP or linear
    std::unique_ptr<DomainUpdate<dim>>   domain_update;   ///< GIMP only
    /** Where a step looks for its middle first; null: it has none. */
    std::unique_ptr<MiddlePlaces<dim>> middle;
    /** From particles to grid. */
    PointMapping mapping;
    /** How large steps are. */
    std::unique_ptr<StepRule<dim>>          step_rule;
    std::unique_ptr<const TravelLimit<dim>> travel_limit; ///< null: none
    /** Particles, and what else a step remembers. */
    RunState<dim> state;
    /** Those of the state. */
    dealii::Particles::ParticleHandler<dim> &particles = state.particles;
    std::unique_ptr<TimeIntegrator<dim>>     stepper; ///< makes steps
    /** Who has which cells. */
    RankBalance<dim> rank_balance;
    /** What more is asked for. */
    std::vector<std::unique_ptr<Measurement<dim>>> measurements;
    std::vector<ParticleField<dim>> written_fields; ///< in particle files
    ParticleNumber<dim>             drawn_number;   ///< in pictures
    /** On which particles effects act, in words. */
    std::vector<std::string> notes;
    StartedFrom              started; ///< of another run, if it does

  private:
    /** Particles: of the bodies, or of another run. Collective. */
    void
    fill_with_particles();
    std::unique_ptr<TimeIntegrator<dim>>
    make_stepper(const SceneParameters<dim> &parameters);
    bool
    has_initial_stress() const;
    /** Add what initial stress stores to row 0. Collective. */
    void
    add_initial_stress(StepReport &report);
    /** Add the measurements of the particles as they are. Collective. */
    void
    measure(StepReport &report);

    /** A number that changes when a particle enters a cell. Collective. */
    std::uint64_t
    occupancy() const;

    const SceneParameters<dim> &parameters;
  };
} // namespace emmy

#endif
