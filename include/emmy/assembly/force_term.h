#ifndef emmy_assembly_force_term_h
#define emmy_assembly_force_term_h

#include <emmy/assembly/step_report.h>
#include <emmy/base/library.h>
#include <emmy/base/phases.h>
#include <emmy/base/section.h>
#include <emmy/transfer/particles_to_grid.h>

#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  template <int dim>
  class MovingPlaces;

  /** All that is fixed while a step is solved. */
  template <int dim>
  struct StepData
  {
    const Stencils<dim>    &stencils;
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
   * A force that depends on the displacement of the step: internal force,
   * inertia, stabilisation. Owned by the balance. Adds its share of the
   * residual r = (inertia + internal force + ...) - loads.
   */
  template <int dim>
  class ForceTerm
  {
  public:
    virtual ~ForceTerm() = default;

    /**
     * Add the force to @p force and, unless null, its derivative to
     * @p jacobian; the constraints are worked into the derivative, not into
     * the force. Collective.
     *
     * @return what is wrong on this rank with the iterate, empty if nothing;
     *   then force and jacobian may be incomplete, but all collective calls
     *   have been made.
     */
    virtual std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const = 0;

    /**
     * The energies of the accepted step, this rank's share. Always the same
     * names in the same order.
     *
     * @param accepted particle states at t + dt
     */
    virtual std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const = 0;

    /** The entries that energies() will return, with no change. */
    virtual std::vector<EnergyEntry>
    energy_entries() const = 0;
  };

  /** A force that is fixed within a step: gravity, point loads. */
  template <int dim>
  class StepLoad
  {
  public:
    virtual ~StepLoad() = default;

    /** Add the load to an array over local nodes: [dim * node + c], N. */
    virtual void
    add(const StepData<dim> &step, std::vector<double> &local_force) const = 0;

    /**
     * Add the load to an array over points, [dim * p + c], N, such that add()
     * gives sum_p S_Ap f_p. Newton needs it where the particles' places are
     * unknowns; a load that has no such form adds nothing, and Newton takes
     * some more iterations.
     */
    virtual void
    add_at_points(const StepData<dim> &step,
                  std::vector<double> &point_force) const
    {
      (void)step;
      (void)point_force;
    }
  };

  /**
   * Chooses particles that an effect acts on and writes an initial field that
   * tells so. Owned by the balance; used once, after the bodies are filled.
   */
  template <int dim>
  class Marker
  {
  public:
    virtual ~Marker() = default;

    /**
     * Write the field. The choice must not depend on the partition; ids do.
     * Collective; throws on all ranks.
     * @return a line for the log: what was chosen; the same on all ranks
     */
    virtual std::string
    mark(const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const = 0;
  };

  /**
   * Measures the particles: numbers of the ledger that enter no balance. Owned
   * by the balance; used once per accepted step, and before the first.
   */
  template <int dim>
  class Probe
  {
  public:
    virtual ~Probe() = default;

    /**
     * Always the same names in the same order. Collective.
     * @param points states at @p time, s
     */
    virtual std::vector<StepMeasure>
    measure(const PointArrays<dim> &points,
            const double            time,
            const MPI_Comm          communicator) const = 0;
  };

  /** All that acts in a scene, inertia and internal force among the terms. */
  template <int dim>
  struct Effects
  {
    std::vector<std::unique_ptr<ForceTerm<dim>>> terms;
    std::vector<std::unique_ptr<StepLoad<dim>>>  loads;
    std::vector<std::unique_ptr<Marker<dim>>>    markers;
    std::vector<std::unique_ptr<Probe<dim>>>     probes;
    /** Faces that ghost stabilisation penalises; null without it. */
    std::unique_ptr<const GhostFaces<dim>> ghost_faces;
    /** Lets starved nodes follow others; null without it. */
    std::unique_ptr<const Aggregation<dim>> aggregation;

    /** Borrowed; one per body. There before the first effect is added. */
    std::vector<const Material<dim> *> material_of_body;

    /** Whose the terms, loads and probes are, in the table of times. */
    std::vector<std::string> term_names, load_names, probe_names;

    /** Book the terms, loads and probes that have no name yet to an effect. */
    void
    name_new(const std::string &effect)
    {
      term_names.resize(terms.size(), effect);
      load_names.resize(loads.size(), effect);
      probe_names.resize(probes.size(), effect);
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
