#ifndef emmy_effects_stress_states_h
#define emmy_effects_stress_states_h

#include <emmy/effects/effect.h>
#include <emmy/effects/point_batch.h>
#include <emmy/material/stress_rules.h>

namespace emmy
{
  /** The name of the internal force, in the table of times. */
  constexpr const char *internal_force_effect = "internal force";

  /**
   * What particles remember of their deformation and stress: b - I, tau and
   * the elastic energy; where a material of the scene has history also
   * b^e - I, the history, the energy stored by hardening and the dissipation so
   * far; where the material of a body varies, its parameters. Reads them in
   * batches at t and writes them at t + dt. Owned by the
   * force that has this stress.
   */
  template <int dim>
  class StressStates
  {
  public:
    /**
     * @param material_of_body borrowed; one per body
     * @param names            of the materials, one per body, for the price of
     *   each; empty: not wanted
     * @param layout           asked for the fields
     */
    StressStates(std::vector<const Material<dim> *> material_of_body,
                 std::vector<std::string>           names,
                 FieldLayout                       &layout);

    /** The card of a force with these fields; elastic. */
    static EffectCard
    card();

    /**
     * The card of a material whose fields are its history, with what has to
     * be kept beside that. Without history nothing is added.
     */
    static EffectCard
    with_history(EffectCard material);

    /** Of a body, by its number. */
    const Material<dim> &
    material(const unsigned int body) const
    {
      return *material_of_body[body];
    }

    /**
     * Call std::string function(batch) for batches of all points, until one
     * returns a problem. The time is booked to the materials, batches of one
     * after another together: that takes no time of its own.
     * @param phases null: no time is booked
     * @return the problem; empty if there was none
     */
    template <class Function>
    std::string
    for_each_batch(const Stencils<dim> &stencils,
                   Phases              *phases,
                   const Function      &function) const
    {
      if (names.empty())
        phases = nullptr;
      std::string     problem;
      PointBatch<dim> points(stencils);
      for (bool has_points = points.next(); has_points && problem.empty();)
        {
          const unsigned int body     = points.body;
          std::size_t        n_points = 0;
          {
            const auto timed =
              effect_scope(phases, phases ? std::string_view(names[body]) : "");
            for (; has_points && problem.empty() &&
                   material_of_body[points.body] == material_of_body[body];
                 has_points = points.next())
              {
                problem = function(points);
                n_points += points.n_points;
              }
          }
          if (phases)
            {
              phases->add_effect_count(internal_force_effect, n_points);
              phases->add_effect_count(names[body], n_points);
            }
        }
      return problem;
    }

    /** Reference volumes of all points, m^3. */
    const double *
    reference_volumes(const PointArrays<dim> &points) const
    {
      return points.component(reference_volume);
    }

    /** tau of a point at t, Pa. */
    MandelVector<dim>
    stress(const PointArrays<dim> &points, const std::size_t p) const
    {
      return points.template get<n_mandel<dim>>(kirchhoff_stress, p);
    }

    /** States at t of the batch that starts at point @p first. */
    void
    read(const PointArrays<dim> &points,
         const unsigned int      body,
         const std::size_t       first,
         StressBatch<dim>       &batch) const;

    /** States at t + dt of that batch. */
    void
    write(const StressBatch<dim> &batch,
          const PointArrays<dim> &points,
          const unsigned int      body,
          const std::size_t       first,
          PointArrays<dim>       &trial) const;

    /**
     * strain_energy; with inelastic materials hardening_energy and
     * plastic_dissipation. This rank's share.
     */
    std::vector<EnergyEntry>
    energies(const PointArrays<dim> &points,
             const PointArrays<dim> &accepted) const;
    /** Names of the stored energies and of what is dissipated. */
    std::vector<EnergyEntry>
    energy_entries() const;

  private:
    /** First components of the fields that only inelastic scenes have. */
    struct InelasticFields
    {
      unsigned int elastic_left_cauchy_green_less_unit,
        hardening_energy_density, plastic_dissipation_density;
      /** Per body: of its material's history. */
      std::vector<std::vector<unsigned int>> history;
    };

    /** Ask for these fields; null if no material has history. */
    static std::unique_ptr<const InelasticFields>
    add_inelastic_fields(
      const std::vector<const Material<dim> *> &material_of_body,
      const std::vector<std::string>           &names,
      FieldLayout                              &layout);

    static std::vector<std::vector<unsigned int>>
    add_parameters(const std::vector<const Material<dim> *> &material_of_body,
                   const std::vector<std::string>           &names,
                   FieldLayout                              &layout);

    void
    read_inelastic(const PointArrays<dim> &points,
                   const unsigned int      body,
                   const std::size_t       first,
                   StressBatch<dim>       &batch) const;
    void
    write_inelastic(const StressBatch<dim> &batch,
                    const PointArrays<dim> &points,
                    const unsigned int      body,
                    const std::size_t       first,
                    PointArrays<dim>       &trial) const;

    const std::vector<const Material<dim> *> material_of_body;
    const std::vector<std::string>           names; // one per body, or none
    const unsigned int reference_volume, left_cauchy_green_less_unit,
      kirchhoff_stress, strain_energy_density;
    const std::unique_ptr<const InelasticFields> inelastic; // none if elastic
    /** Of the parameters() of each body's material. */
    const std::vector<std::vector<unsigned int>> parameters;
  };

  /** A particle with det(Delta F) <= 0, in words. */
  template <int dim>
  std::string
  inverted_particle(const Stencils<dim> &stencils, const std::size_t point);
} // namespace emmy

#endif
