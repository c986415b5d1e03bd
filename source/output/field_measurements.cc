#include <emmy/math/mandel.h>
#include <emmy/output/field_measurements.h>
#include <emmy/output/particle_fields.h>
#include <emmy/particles/nearest.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  using dealii::Point;

  namespace
  {
    template <int dim>
    using Particles = dealii::Particles::ParticleHandler<dim>;

    template <int dim>
    using Particle = typename ParticleField<dim>::Particle;

    /** Fields, and the columns that they are in. */
    template <int dim>
    class FieldColumns
    {
    public:
      /** Throws ExcParameter. */
      FieldColumns(const FieldLayout              &layout,
                   const std::vector<std::string> &names,
                   const std::string              &section)
      {
        std::vector<std::string> others = names;
        const auto               position =
          std::find(others.begin(), others.end(), "position");
        has_position = position != others.end();
        if (has_position)
          others.erase(position);
        fields = ParticleFields<dim>(layout).find(others, section, "Fields");
      }

      /** The ends of the columns' names. */
      std::vector<std::string>
      suffixes() const
      {
        std::vector<std::string> result;
        for (unsigned int d = 0; d < dim && has_position; ++d)
          result.push_back(std::string(1, "xyz"[d]));
        for (const ParticleField<dim> &field : fields)
          for (const auto &[ending, at] : field.components)
            result.push_back(field.description.name +
                             (ending.empty() ? "" : "_" + ending));
        return result;
      }

      /** Add weight times the values of a particle to the sums of columns. */
      void
      add(const Particle<dim> &particle, const double weight, double *sum) const
      {
        for (unsigned int d = 0; d < dim && has_position; ++d)
          *sum++ += weight * particle.get_location()[d];
        std::vector<double> values;
        for (const ParticleField<dim> &field : fields)
          {
            values.clear();
            field.append(particle, values);
            for (const auto &[ending, at] : field.components)
              *sum++ += weight * values[at];
          }
      }

    private:
      bool                            has_position;
      std::vector<ParticleField<dim>> fields;
    };

    std::vector<StepMeasure>
    as_columns(const EffectCard &card, const std::vector<double> &values)
    {
      std::vector<StepMeasure> result;
      for (unsigned int i = 0; i < values.size(); ++i)
        result.push_back({card.ledger_columns[i], values[i]});
      return result;
    }

    /** Fields of some particles, in the mean. */
    template <int dim>
    class FollowedParticles : public Measurement<dim>
    {
    public:
      /** @param ids of the particles, which they keep: sorted */
      FollowedParticles(const std::vector<dealii::types::particle_index> &ids,
                        const FieldColumns<dim> &fields,
                        const MPI_Comm           communicator,
                        const EffectCard        &own_card)
        : ids(ids)
        , fields(fields)
        , communicator(communicator)
        , own_card(own_card)
      {}

      std::vector<StepMeasure>
      measure(const Particles<dim> &particles) const override
      {
        std::vector<double> sums(own_card.ledger_columns.size());
        for (const auto &particle : particles)
          if (std::binary_search(ids.begin(), ids.end(), particle.get_id()))
            fields.add(particle, 1., sums.data());
        dealii::Utilities::MPI::sum(sums, communicator, sums);
        for (double &sum : sums)
          sum /= ids.size();
        return as_columns(own_card, sums);
      }

      const EffectCard &
      card() const override
      {
        return own_card;
      }

      std::vector<dealii::types::particle_index>
      memory() const override
      {
        return ids;
      }

      void
      recall(const std::vector<dealii::types::particle_index> &memory) override
      {
        ids = memory;
      }

    private:
      std::vector<dealii::types::particle_index> ids;
      const FieldColumns<dim>                    fields;
      const MPI_Comm                             communicator;
      const EffectCard                           own_card;
    };

    /** The entry <Fields>. */
    template <int dim>
    class FieldParameters : public MeasurementParameters<dim>
    {
    public:
      FieldParameters(const std::string              &section,
                      const std::vector<std::string> &usual)
        : MeasurementParameters<dim>(section)
        , field_names(usual)
      {
        this->add_parameter(
          "Fields",
          field_names,
          "What is measured: position (m), or the names that "
          "Output/Particle fields knows, as cauchy_stress (Pa), "
          "logarithmic_strain, pressure (Pa) or displacement (m). Of tensors "
          "the components that differ; in plane strain xx, yy, zz and xy.",
          this->prm,
          dealii::Patterns::List(dealii::Patterns::Anything(), 1));
      }

      std::vector<std::string>
      fields() const override
      {
        return field_names;
      }

    protected:
      std::vector<std::string> field_names;
    };

    template <int dim>
    Point<dim>
    as_point(const std::vector<double> &coordinates)
    {
      Point<dim> result;
      std::copy_n(coordinates.begin(), dim, result.begin_raw());
      return result;
    }

    template <int dim>
    class ParticleParameters : public FieldParameters<dim>
    {
    public:
      explicit ParticleParameters(const std::string &section)
        : FieldParameters<dim>(section, {"position"})
      {
        this->add_parameter(
          "Nearest to",
          position,
          "The particle that is nearest to this position at the start is "
          "followed; of several equally near ones their mean. Unit: m. "
          "Required: " +
            std::to_string(dim) + " coordinates.",
          this->prm,
          dealii::Patterns::List(dealii::Patterns::Double(), 0, dim));
      }

      std::unique_ptr<Measurement<dim>>
      make(const FilledBodies<dim> &filled) const override
      {
        const std::string text = dealii::Patterns::Tools::to_string(position);
        AssertThrow(position.size() == dim,
                    ExcParameter(this->path(),
                                 "Nearest to",
                                 text,
                                 "it is required: " + std::to_string(dim) +
                                   " coordinates in m, separated by , or ;."));
        const unsigned int body      = this->body_index(filled.bodies);
        const unsigned int component = filled.layout["body"];
        const auto         counts    = [=](const auto &particle) {
          return body == this->all_bodies ||
                 particle.get_properties()[component] == body;
        };
        const NearestParticles<dim> nearest({as_point<dim>(position)},
                                            this->path(),
                                            "Nearest to",
                                            filled.grid,
                                            filled.particles,
                                            counts);

        std::vector<dealii::types::particle_index> own, ids;
        for (const auto &particle : filled.particles)
          if (counts(particle) &&
              nearest.is_nearest(0, particle.get_location()))
            own.push_back(particle.get_id());
        const MPI_Comm communicator = filled.grid.communicator();
        for (const auto &of_rank :
             dealii::Utilities::MPI::all_gather(communicator, own))
          ids.insert(ids.end(), of_rank.begin(), of_rank.end());
        std::sort(ids.begin(), ids.end());
        Assert(!ids.empty(), dealii::ExcInternalError()); // no body is empty

        const FieldColumns<dim> columns(filled.layout,
                                        this->field_names,
                                        this->path());
        const std::string       what =
          (ids.size() == 1
             ? std::string("the particle")
             : "the mean of " + std::to_string(ids.size()) + " particles") +
          " that started " + brief(nearest.distances()[0]) + " m from (" +
          text + ") m";
        return std::make_unique<FollowedParticles<dim>>(
          ids,
          columns,
          communicator,
          this->make_card(what, columns.suffixes()));
      }

    private:
      std::vector<double> position; // m
    };

    /** Which particles count for a mean, and how much. */
    template <int dim>
    struct Region
    {
      static constexpr unsigned int all = dealii::numbers::invalid_unsigned_int;

      Point<dim>   lower, upper; // m
      unsigned int body;         // all: of any
      unsigned int body_component, volume, left_cauchy_green_less_unit;

      /** The volume now, m^3; 0 outside of the region. */
      double
      volume_of(const Particle<dim> &particle) const
      {
        const auto properties = particle.get_properties();
        if (body != all && properties[body_component] != body)
          return 0.;
        for (unsigned int d = 0; d < dim; ++d)
          if (particle.get_location()[d] < lower[d] ||
              particle.get_location()[d] > upper[d])
            return 0.;
        MandelVector<dim> b;
        for (unsigned int c = 0; c < n_mandel<dim>; ++c)
          b[c] = properties[left_cauchy_green_less_unit + c];
        return properties[volume] *
               std::sqrt(1. + mandel::determinant_less_one<dim>(b));
      }
    };

    template <int dim>
    class RegionMean : public Measurement<dim>
    {
    public:
      RegionMean(const Region<dim>       &region,
                 const FieldColumns<dim> &fields,
                 const MPI_Comm           communicator,
                 const EffectCard        &own_card)
        : region(region)
        , fields(fields)
        , communicator(communicator)
        , own_card(own_card)
      {}

      std::vector<StepMeasure>
      measure(const Particles<dim> &particles) const override
      {
        std::vector<double> sums(own_card.ledger_columns.size());
        for (const auto &particle : particles)
          if (const double volume = region.volume_of(particle); volume > 0.)
            {
              sums[0] += volume;
              fields.add(particle, volume, sums.data() + 1);
            }
        dealii::Utilities::MPI::sum(sums, communicator, sums);
        for (unsigned int i = 1; i < sums.size() && sums[0] > 0.; ++i)
          sums[i] /= sums[0];
        return as_columns(own_card, sums);
      }

      const EffectCard &
      card() const override
      {
        return own_card;
      }

    private:
      const Region<dim>       region;
      const FieldColumns<dim> fields;
      const MPI_Comm          communicator;
      const EffectCard        own_card;
    };

    template <int dim>
    class MeanParameters : public FieldParameters<dim>
    {
    public:
      explicit MeanParameters(const std::string &section)
        : FieldParameters<dim>(section, {"cauchy_stress"})
      {
        const dealii::Patterns::List corner(dealii::Patterns::Double(), 0, dim);
        this->add_parameter("Lower corner",
                            lower,
                            "Of the box whose particles count; it stays where "
                            "it is. Unit: m. Empty: all of the grid.",
                            this->prm,
                            corner);
        this->add_parameter("Upper corner",
                            upper,
                            "See <Lower corner>. Unit: m.",
                            this->prm,
                            corner);
      }

      std::unique_ptr<Measurement<dim>>
      make(const FilledBodies<dim> &filled) const override
      {
        const auto &layout = filled.layout;
        Region<dim> region;
        region.lower =
          corner("Lower corner", lower, filled.grid.lower_corner());
        region.upper =
          corner("Upper corner", upper, filled.grid.upper_corner());
        region.body           = this->body_index(filled.bodies);
        region.body_component = layout["body"];
        region.volume         = layout["reference_volume"];
        region.left_cauchy_green_less_unit =
          layout["left_cauchy_green_less_unit"];

        unsigned long n = 0;
        for (const auto &particle : filled.particles)
          n += region.volume_of(particle) > 0.;
        n = dealii::Utilities::MPI::sum(n, filled.grid.communicator());
        AssertThrow(n > 0,
                    ExcParameter(this->path(),
                                 "Lower corner",
                                 dealii::Patterns::Tools::to_string(lower),
                                 "there is no particle in this box at the "
                                 "start. Move it, or enlarge it."));
        const FieldColumns<dim>  columns(layout,
                                        this->field_names,
                                        this->path());
        std::vector<std::string> suffixes = columns.suffixes();
        suffixes.insert(suffixes.begin(), "volume");
        return std::make_unique<RegionMean<dim>>(
          region,
          columns,
          filled.grid.communicator(),
          this->make_card("the mean of the particles in a box, " +
                            std::to_string(n) + " at the start",
                          suffixes));
      }

    private:
      /** Throws ExcParameter. */
      Point<dim>
      corner(const std::string         &name,
             const std::vector<double> &given,
             const Point<dim>          &of_grid) const
      {
        if (given.empty())
          return of_grid;
        AssertThrow(given.size() == dim,
                    ExcParameter(this->path(),
                                 name,
                                 dealii::Patterns::Tools::to_string(given),
                                 "it must be empty, or have " +
                                   std::to_string(dim) +
                                   " coordinates in m, separated by , or ;."));
        return as_point<dim>(given);
      }

      std::vector<double> lower, upper; // m
    };
  } // namespace

  template <int dim>
  std::unique_ptr<MeasurementParameters<dim>>
  make_particle_parameters(const std::string &section)
  {
    return std::make_unique<ParticleParameters<dim>>(section);
  }

  template <int dim>
  std::unique_ptr<MeasurementParameters<dim>>
  make_mean_parameters(const std::string &section)
  {
    return std::make_unique<MeanParameters<dim>>(section);
  }

#define INSTANTIATE(dim)                               \
  template std::unique_ptr<MeasurementParameters<dim>> \
  make_particle_parameters<dim>(const std::string &);  \
  template std::unique_ptr<MeasurementParameters<dim>> \
  make_mean_parameters<dim>(const std::string &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
