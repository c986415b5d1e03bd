#ifndef emmy_output_measurement_h
#define emmy_output_measurement_h

#include <emmy/base/effect_card.h>
#include <emmy/base/library.h>
#include <emmy/base/section.h>
#include <emmy/effects/step_report.h>
#include <emmy/particles/body.h>

#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * A quantity that a scene asks for beyond energies and momenta, as columns
   * of the ledger: what the particles are like at the end of a step. It reads
   * particles, and nothing reads it but the ledger.
   *
   * Owned by the scene, which measures the initial state and each accepted
   * step. Cost: a pass over the particles and a reduction over the ranks.
   */
  template <int dim>
  class Measurement
  {
  public:
    virtual ~Measurement() = default;

    /** Columns of the ledger, m. Collective. */
    virtual std::vector<StepMeasure>
    measure(const dealii::Particles::ParticleHandler<dim> &particles) const = 0;

    /** What was chosen at the start and is not in the particles; the same on
     * all ranks. */
    virtual std::vector<dealii::types::particle_index>
    memory() const
    {
      return {};
    }

    /** Go on from a checkpoint with what memory() was then. */
    virtual void
    recall(const std::vector<dealii::types::particle_index> &memory)
    {
      (void)memory;
    }

    /** Its name, what it measures in words, and its columns. */
    virtual const EffectCard &
    card() const = 0;
  };

  /** The bodies of a scene that has just been filled with particles. */
  template <int dim>
  struct FilledBodies
  {
    const std::vector<Body<dim>>                  &bodies;    ///< of the scene
    const BackgroundGrid<dim>                     &grid;      ///< of the scene
    const FieldLayout                             &layout;    ///< of the scene
    const dealii::Particles::ParticleHandler<dim> &particles; ///< of this rank
  };

  /** Section `Measurements/NAME`. */
  template <int dim>
  class MeasurementParameters : public Section
  {
  public:
    /** Declares <Type> and <Body>; the types declare the rest. */
    explicit MeasurementParameters(const std::string &section);

    /** Check and build. Throws ExcParameter. Collective. */
    virtual std::unique_ptr<Measurement<dim>>
    make(const FilledBodies<dim> &filled) const = 0;

    /** The fields of particles that it reads, if it lists some. */
    virtual std::vector<std::string>
    fields() const
    {
      return {};
    }

  protected:
    /** The index of <Body>; all_bodies if it is empty. Throws ExcParameter. */
    unsigned int
    body_index(const std::vector<Body<dim>> &bodies) const;

    /** With these columns, each NAME_suffix. */
    EffectCard
    make_card(const std::string              &what,
              const std::vector<std::string> &suffixes) const;

    /** No body is named. */
    static constexpr unsigned int all_bodies =
      dealii::numbers::invalid_unsigned_int;

    std::string body; ///< empty: all bodies

  private:
    std::string type; // decides, before this is made, what is made
  };

  /** All measurements that a parameter file can name. */
  template <int dim>
  Library<MeasurementParameters<dim>> &
  measurement_library();
} // namespace emmy

#endif
