#include <emmy/output/field_measurements.h>

#include <algorithm>
#include <limits>

namespace emmy
{
  namespace
  {
    template <int dim>
    using Particles = dealii::Particles::ParticleHandler<dim>;

    /** Columns with their values. */
    std::vector<StepMeasure>
    as_columns(const EffectCard &card, const std::vector<double> &values)
    {
      std::vector<StepMeasure> result;
      for (unsigned int i = 0; i < values.size(); ++i)
        result.push_back({card.ledger_columns[i], values[i]});
      return result;
    }

    /** The box around a body, parallel to the axes. */
    template <int dim>
    class Extent : public Measurement<dim>
    {
    public:
      /**
       * @param body        its index, or that of all of them
       * @param half_length component of the particles' domains; all_bodies:
       *   they are points
       */
      Extent(const unsigned int body,
             const unsigned int body_component,
             const unsigned int half_length,
             const MPI_Comm     communicator,
             const EffectCard  &own_card)
        : body(body)
        , body_component(body_component)
        , half_length(half_length)
        , communicator(communicator)
        , own_card(own_card)
      {}

      std::vector<StepMeasure>
      measure(const Particles<dim> &particles) const override
      {
        // -lower and upper in each direction
        std::vector<double> reach(2 * dim,
                                  std::numeric_limits<double>::lowest());
        for (const auto &particle : particles)
          {
            const auto properties = particle.get_properties();
            if (body != none && properties[body_component] != body)
              continue;
            for (unsigned int d = 0; d < dim; ++d)
              {
                const double x = particle.get_location()[d];
                const double l =
                  half_length == none ? 0. : properties[half_length + d];
                reach[2 * d]     = std::max(reach[2 * d], l - x);
                reach[2 * d + 1] = std::max(reach[2 * d + 1], x + l);
              }
          }
        dealii::Utilities::MPI::max(reach, communicator, reach);
        for (unsigned int d = 0; d < dim; ++d)
          reach[2 * d] *= -1.;
        return as_columns(own_card, reach);
      }

      const EffectCard &
      card() const override
      {
        return own_card;
      }

      static constexpr unsigned int none =
        dealii::numbers::invalid_unsigned_int;

    private:
      const unsigned int body, body_component, half_length;
      const MPI_Comm     communicator;
      const EffectCard   own_card;
    };

    template <int dim>
    class ExtentParameters : public MeasurementParameters<dim>
    {
    public:
      using MeasurementParameters<dim>::MeasurementParameters;

      std::unique_ptr<Measurement<dim>>
      make(const FilledBodies<dim> &filled) const override
      {
        std::vector<std::string> suffixes;
        for (unsigned int d = 0; d < dim; ++d)
          for (const std::string end : {"lower_", "upper_"})
            suffixes.push_back(end + "xyz"[d]);
        const FieldLayout &layout     = filled.layout;
        const bool         has_domain = layout.has("half_length");
        const std::string  what =
          "the extent of the " +
          std::string(has_domain ? "domains of the particles" : "particles") +
          (this->body.empty() ? "" : " of <" + this->body + ">");
        return std::make_unique<Extent<dim>>(this->body_index(filled.bodies),
                                             layout["body"],
                                             has_domain ? layout["half_length"]
                                                        : Extent<dim>::none,
                                             filled.grid.communicator(),
                                             this->make_card(what, suffixes));
      }
    };
  } // namespace

  template <int dim>
  MeasurementParameters<dim>::MeasurementParameters(const std::string &section)
    : Section(section)
  {
    this->add_parameter("Type",
                        type,
                        "What is measured: " +
                          join(measurement_library<dim>().names()) +
                          ". Required.");
    this->add_parameter("Body",
                        body,
                        "One of Bodies/Names, whose particles count. Empty: "
                        "those of all bodies.");
  }

  template <int dim>
  unsigned int
  MeasurementParameters<dim>::body_index(
    const std::vector<Body<dim>> &bodies) const
  {
    if (body.empty())
      return all_bodies;
    std::vector<std::string> names;
    for (const Body<dim> &one : bodies)
      names.push_back(one.name);
    const auto        position = std::find(names.begin(), names.end(), body);
    const std::string nearest  = nearest_name(body, names);
    AssertThrow(position != names.end(),
                ExcParameter(path(),
                             "Body",
                             body,
                             (nearest.empty()
                                ? std::string()
                                : "did you mean <" + nearest + ">? ") +
                               "It must be empty, or one of Bodies/Names: " +
                               join(names) + "."));
    return position - names.begin();
  }

  template <int dim>
  EffectCard
  MeasurementParameters<dim>::make_card(
    const std::string              &what,
    const std::vector<std::string> &suffixes) const
  {
    const std::string name = path().substr(path().find('/') + 1);
    EffectCard        card;
    card.name       = "measurement " + name;
    card.enters     = "after the step: " + what;
    card.is_present = true;
    for (const std::string &suffix : suffixes)
      card.ledger_columns.push_back(name + "_" + suffix);
    return card;
  }

  template <int dim>
  Library<MeasurementParameters<dim>> &
  measurement_library()
  {
    static Library<MeasurementParameters<dim>> library = [] {
      Library<MeasurementParameters<dim>> measurements;
      measurements.add({"particle",
                        "path, stress or other fields of the particle that "
                        "starts nearest to a position",
                        make_particle_parameters<dim>});
      measurements.add({"extent",
                        "the box around a body, parallel to the axes",
                        [](const std::string &section) {
                          return std::make_unique<ExtentParameters<dim>>(
                            section);
                        }});
      measurements.add({"mean",
                        "mean stress or other fields of the particles in a "
                        "box, by volume",
                        make_mean_parameters<dim>});
      return measurements;
    }();
    return library;
  }

  template class MeasurementParameters<2>;
  template class MeasurementParameters<3>;
  template Library<MeasurementParameters<2>> &
  measurement_library<2>();
  template Library<MeasurementParameters<3>> &
  measurement_library<3>();
} // namespace emmy
