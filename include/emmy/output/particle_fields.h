#ifndef emmy_output_particle_fields_h
#define emmy_output_particle_fields_h

#include <emmy/base/effect_card.h>
#include <emmy/output/data_file.h>
#include <emmy/particles/field_layout.h>

#include <deal.II/particles/particle_accessor.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /**
   * What a file, a picture or a measurement can say of a particle: a quantity
   * that it carries, or one that follows from these.
   */
  template <int dim>
  struct ParticleField
  {
    /** One of deal.II's. */
    using Particle = dealii::Particles::ParticleAccessor<dim>;

    FieldDescription description; ///< name, unit and size
    /** Appends description.n_components numbers; a tensor by rows, 3x3. */
    std::function<void(const Particle &, std::vector<double> &)> append;
    /**
     * The components that differ, by the end of their names (as xx), and where
     * they stand in what is appended. Of a scalar: one without a name.
     */
    std::vector<std::pair<std::string, unsigned int>> components;
    /** Whether particles carry it as it is. */
    bool is_carried = false;
  };

  /** One number of a particle, for a picture. */
  template <int dim>
  struct ParticleNumber
  {
    /** In words, with its unit, for gnuplot: as "strain energy (J/m^3)". */
    std::string label;
    /** Of one component. */
    std::function<double(const typename ParticleField<dim>::Particle &)> value;
  };

  /**
   * All that can be said of the particles of a scene. What particles carry,
   * under the names of their fields, and
   *  - cauchy_stress: sigma = tau/J, J = sqrt(det b), Pa; a 3x3 tensor, in
   *    plane strain too;
   *  - pressure: -tr(sigma)/3, Pa, positive in compression;
   *  - von_mises_stress: sqrt(3/2 s:s) of the deviator s of sigma, Pa;
   *  - logarithmic_strain: 1/2 ln b, b = F F^T, of elastic and plastic
   *    deformation together; elastic_strain: of the elastic one alone;
   *  - displacement: from where the particle was at the start of the run, m;
   *    only if the particles carry where that was (@ref add_start_position).
   *
   * Made where it is needed; cost: none until a field is evaluated.
   */
  template <int dim>
  class ParticleFields
  {
  public:
    /** @param layout of the scene, complete */
    explicit ParticleFields(const FieldLayout &layout);

    /** As in `Particle fields`. */
    std::vector<std::string>
    names() const;

    /**
     * The fields of these names, in this order, each once; <carried> stands
     * for all that particles carry. Throws ExcParameter, with the nearest
     * name, for one that is not there.
     * @param section,entry that the user wrote
     */
    std::vector<ParticleField<dim>>
    find(const std::vector<std::string> &wanted,
         const std::string              &section,
         const std::string              &entry) const;

    /**
     * A number: a scalar, the length of a vector, or a component, as
     * cauchy_stress_yy or velocity_x. Throws ExcParameter.
     */
    ParticleNumber<dim>
    number(const std::string &wanted,
           const std::string &section,
           const std::string &entry) const;

  private:
    std::vector<ParticleField<dim>> fields;
  };

  /** The field by which particles know where they started. */
  constexpr const char *start_position_field = "start_position";

  /** Whether one of these names asks for displacements. */
  bool
  wants_displacement(const std::vector<std::string> &names);

  /** Ask for the field, of numbers that are no position yet. */
  void
  add_start_position(FieldLayout &layout);

  /** What it costs to know the displacements. */
  EffectCard
  displacement_card(const bool is_present);

  /**
   * Particles that do not know where they started do so here. Others, as those
   * of another run that this one starts from, keep their start.
   */
  template <int dim, typename Particles>
  void
  set_start_position(const FieldLayout &layout, Particles &particles)
  {
    const unsigned int start = layout[start_position_field];
    for (auto &particle : particles)
      {
        const auto properties = particle.get_properties();
        for (unsigned int d = 0; d < dim; ++d)
          if (properties[start + d] != properties[start + d]) // not a number
            properties[start + d] = particle.get_location()[d];
      }
  }
} // namespace emmy

#endif
