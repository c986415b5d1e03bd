#ifndef emmy_effects_effect_h
#define emmy_effects_effect_h

#include <emmy/base/library.h>
#include <emmy/base/phases.h>
#include <emmy/base/section.h>
#include <emmy/base/surface.h>
#include <emmy/effects/added_mass.h>
#include <emmy/effects/given_motion.h>
#include <emmy/effects/load.h>
#include <emmy/effects/load_ramp.h>
#include <emmy/effects/node_coupling.h>
#include <emmy/effects/step_measures.h>
#include <emmy/effects/step_memory.h>
#include <emmy/effects/velocity_map.h>
#include <emmy/material/material.h>
#include <emmy/system/couplings.h>
#include <emmy/transfer/particles_to_grid.h>

#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  template <int dim>
  class MovingPlaces;
  class ParameterFile;

  /** All that is fixed while a step is solved. */
  template <int dim>
  struct StepData
  {
    const Stencils<dim>    &stencils;  ///< of the start of the step
    const PointArrays<dim> &points;    ///< states at t
    const GridStart<dim>   &start;     ///< mass, momentum, velocity at t
    double                  time;      ///< t, s
    double                  time_step; ///< s
    /** Where the time of effects is booked; null: nowhere. */
    Phases *phases = nullptr;
    /**
     * Where the particles' places follow the nodes, this makes the derivative
     * of their inertia and stress; null where they stay.
     */
    MovingPlaces<dim> *moving = nullptr;
    /** Of loads that are being raised; null: they act in full. */
    const LoadRamp *ramp = nullptr;
  };

  /** A displacement that Newton tries. */
  template <int dim>
  struct Iterate
  {
    const Vector &displacement; ///< of the step, u, m
    /** The same at the local nodes: [dim * node + component]. */
    const std::vector<double> &local_displacement;
    /** Particle states at t + dt, written by the terms that own them. */
    PointArrays<dim> &trial;
  };

  /**
   * An effect, or a part of one: whatever acts in a scene beside the grid and
   * the particles. Its hooks are called in the order of a step, and do nothing
   * by default. What it finds in a step (faces, roots) it keeps itself, until
   * it is asked to find it anew. What some effects have and others have not
   * is a role with hooks of its own, which the effect hands out: a mass, a
   * load, what couples nodes, a memory.
   *
   * Owned by the balance. All hooks but those of loads are collective.
   */
  template <int dim>
  class Effect
  {
  public:
    virtual ~Effect() = default;

    /**
     * Once, after the bodies are filled: choose the particles that the effect
     * acts on, and write an initial field that tells so. The choice must not
     * depend on the partition; ids do. Throws on all ranks.
     * @return a line for the log: what was chosen, the same on all ranks; or
     *   empty
     */
    virtual std::string
    mark(const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const
    {
      (void)grid;
      (void)particles;
      return "";
    }

    /** What it hands from one of its steps to the next; null: nothing. */
    virtual StepMemory *
    memory()
    {
      return nullptr;
    }

    /** How it couples nodes, or looks at them; null: it does not. */
    virtual NodeCoupling<dim> *
    coupling()
    {
      return nullptr;
    }

    /** Its own mass; null: it has none. */
    virtual const AddedMass<dim> *
    added_mass() const
    {
      return nullptr;
    }

    /**
     * The effect's own map from momentum to velocity; null: it has none. At
     * most one effect of a scene has one.
     */
    virtual VelocityMap<dim> *
    velocity_map()
    {
      return nullptr;
    }

    /** The motion that it gives to fixed components; null: none. */
    virtual const GivenMotion<dim> *
    given_motion() const
    {
      return nullptr;
    }

    /**
     * Before a step is tried: throw ExcRun on all ranks if it must not be done.
     * @param where "Step 3 from t = 0.2 s"
     */
    virtual void
    check_step(const double       time,
               const double       time_step,
               const std::string &where) const
    {
      (void)time;
      (void)time_step;
      (void)where;
    }

    /**
     * Of the step that will be accepted: the forces on the body that hold fixed
     * unknowns, with what followers have handed over to them, N; zero
     * elsewhere.
     */
    virtual void
    see_reactions(const ActiveGrid<dim> &active, const Vector &force)
    {
      (void)active;
      (void)force;
    }

    /**
     * Once a step is solved: the states at its end that the effect keeps and
     * that none of its forces writes. Domains follow behind it.
     * @param displacement of the step at the local nodes, [dim * node + c], m
     */
    virtual void
    follow(const Stencils<dim>       &stencils,
           const PointArrays<dim>    &points,
           const ActiveGrid<dim>     &active,
           const std::vector<double> &displacement,
           PointArrays<dim>          &trial) const
    {
      (void)stencils;
      (void)points;
      (void)active;
      (void)displacement;
      (void)trial;
    }

    /** Once a step from @p time on is accepted. */
    virtual void
    end_step(const double time, const double time_step)
    {
      (void)time;
      (void)time_step;
    }

    /** Its force that is fixed within a step; null: none. */
    virtual const Load<dim> *
    load() const
    {
      return nullptr;
    }

    /** Whether there is a force that depends on the displacement. */
    virtual bool
    is_force() const
    {
      return false;
    }

    /** Whether that force has kinks, see NonlinearEquation. */
    virtual bool
    has_kinks() const
    {
      return false;
    }

    /**
     * Add the force, a share of the residual r = (inertia + internal force +
     * ...) - loads, to @p force and, unless null, its derivative to
     * @p jacobian; the constraints are worked into the derivative, not into
     * the force.
     *
     * @return what is wrong on this rank with the iterate, empty if nothing;
     *   then force and jacobian may be incomplete, but all collective calls
     *   have been made.
     */
    virtual std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const
    {
      (void)step;
      (void)iterate;
      (void)force;
      (void)jacobian;
      return "";
    }

    /**
     * The energies of the accepted step, this rank's share. Always the same
     * names in the same order.
     *
     * @param accepted particle states at t + dt
     */
    virtual std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const
    {
      (void)step;
      (void)displacement;
      (void)accepted;
      return {};
    }

    /** The entries that energies() will return, with no change. */
    virtual std::vector<EnergyEntry>
    energy_entries() const
    {
      return {};
    }

    /**
     * The same entries before the first step: what is stored then, and as work
     * what put it there. This rank's share.
     * @param points states at @p time, s
     */
    virtual std::vector<EnergyEntry>
    energies_at_start(const PointArrays<dim> &points, const double time) const
    {
      (void)points;
      (void)time;
      return energy_entries();
    }

    /** Its numbers of the ledger that enter no balance; null: none. */
    virtual StepMeasures<dim> *
    measures()
    {
      return nullptr;
    }

    /**
     * Surfaces to be shown beside the particles, as they are at a time, s;
     * always the same number. Asked on one rank.
     * @param lower,upper the box in which they are shown, m
     */
    virtual std::vector<Surface<dim>>
    surfaces(const double              time,
             const dealii::Point<dim> &lower,
             const dealii::Point<dim> &upper) const
    {
      (void)time;
      (void)lower;
      (void)upper;
      return {};
    }

    /** A line for the log, of an accepted step; or empty. */
    virtual std::string
    finding()
    {
      return "";
    }
  };

  /** An effect that is a force on the displacement, and no more. */
  template <int dim>
  class ForceTerm : public Effect<dim>
  {
  public:
    bool
    is_force() const override
    {
      return true;
    }
    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override = 0;
    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override = 0;
    std::vector<EnergyEntry>
    energy_entries() const override = 0;
  };

  /** All that acts in a scene, inertia and internal force among the terms. */
  template <int dim>
  struct Effects
  {
    /** In the order in which they act. */
    std::vector<std::unique_ptr<Effect<dim>>> terms;

    /** Borrowed; one per body. There before the first effect is added. */
    std::vector<const Material<dim> *> material_of_body;

    /** Half the boxes that particles start with, m; one per body, likewise. */
    std::vector<dealii::Tensor<1, dim>> half_length_of_body;

    /**
     * The velocity field of each body; empty: all have the same. At most one
     * effect chooses them.
     */
    std::vector<unsigned int> field_of_body;

    /** Names of the bodies; there before the first effect is added. */
    std::vector<std::string> body_names;

    /** Whose the terms are, in the table of times. */
    std::vector<std::string> term_names;

    /** Book the terms that have no name yet to an effect. */
    void
    name_new(const std::string &effect)
    {
      term_names.resize(terms.size(), effect);
    }
  };

  /** The section of an effect, e.g. "Effects/Gravity". */
  template <int dim>
  class EffectParameters : public Section
  {
  public:
    using Section::Section;

    /**
     * Check, build, and add to the scene's effects. Throws ExcParameter.
     * @param layout to ask for the particle fields that the effect needs
     */
    virtual void
    add_to(Effects<dim> &effects, FieldLayout &layout) const = 0;

    /** Declare what belongs to names in the file; before that is parsed. */
    virtual void
    declare_named(const ParameterFile &)
    {}

    /**
     * Statements for the section that name one of each thing it can hold, for
     * the reference of all parameters; or empty.
     */
    virtual std::string
    one_of_each() const
    {
      return "";
    }

    /**
     * Below which part of a full mass nodes must follow others for the effect
     * to do well; used where a scene gives no such threshold. 0: any.
     */
    virtual double
    least_threshold() const
    {
      return 0.;
    }

    /** The library's card with what the scene names. */
    virtual EffectCard
    card_in_scene(const EffectCard &of_library) const
    {
      return of_library;
    }
  };

  /** All effects that Effects/Names can list. */
  template <int dim>
  Library<EffectParameters<dim>> &
  effect_library();

  /** "gravity" -> "Effects/Gravity": the section of an effect. */
  std::string
  effect_section(const std::string &effect_name);
} // namespace emmy

#endif
