#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/material/principal_axes.h>
#include <emmy/output/particle_fields.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace emmy
{
  namespace
  {
    constexpr const char *displacement  = "displacement";
    constexpr const char *output_effect = "displacement output";

    template <int dim>
    using Particle = typename ParticleField<dim>::Particle;

    /** Append a symmetric tensor as 3x3 by rows. */
    template <int dim>
    void
    append_symmetric(const MandelVector<dim> &a, std::vector<double> &values)
    {
      const auto A = mandel::block<dim>(a);
      for (unsigned int i = 0; i < 3; ++i)
        for (unsigned int j = 0; j < 3; ++j)
          if (i < dim && j < dim)
            values.push_back(A[i][j]);
          else
            values.push_back(dim == 2 && i == 2 && j == 2 ? a[n_mandel<dim> - 1]
                                                          : 0.);
    }

    std::vector<std::pair<std::string, unsigned int>>
    vector_components(const unsigned int dim)
    {
      std::vector<std::pair<std::string, unsigned int>> result;
      for (unsigned int d = 0; d < dim; ++d)
        result.emplace_back(std::string(1, "xyz"[d]), d);
      return result;
    }

    std::vector<std::pair<std::string, unsigned int>>
    symmetric_components(const unsigned int dim)
    {
      if (dim == 2)
        return {{"xx", 0}, {"yy", 4}, {"zz", 8}, {"xy", 1}};
      return {{"xx", 0}, {"yy", 4}, {"zz", 8}, {"xy", 1}, {"xz", 2}, {"yz", 5}};
    }

    std::vector<std::pair<std::string, unsigned int>>
    tensor_components(const unsigned int dim)
    {
      std::vector<std::pair<std::string, unsigned int>> result;
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int j = 0; j < dim; ++j)
          result.emplace_back(std::string{"xyz"[i], "xyz"[j]}, 3 * i + j);
      return result;
    }

    /** A field that particles carry, as it is written. */
    template <int dim>
    ParticleField<dim>
    carried(const Field &field)
    {
      ParticleField<dim> result;
      result.description = {field.written_name(),
                            field.n_components,
                            field.unit,
                            field.description};
      result.is_carried  = true;
      result.components  = {{"", 0}};
      result.append = [field](const Particle<dim> &particle, auto &values) {
        for (unsigned int c = 0; c < field.n_components; ++c)
          values.push_back(
            field.written(c, particle.get_properties()[field.offset + c]));
      };
      if (field.kind == Field::Kind::vector)
        result.components = vector_components(dim);
      if (field.kind == Field::Kind::symmetric_tensor)
        {
          result.description.n_components = 9;
          result.components               = symmetric_components(dim);
          result.append = [field](const Particle<dim> &particle, auto &values) {
            MandelVector<dim> a;
            for (unsigned int c = 0; c < n_mandel<dim>; ++c)
              a[c] =
                field.written(c, particle.get_properties()[field.offset + c]);
            append_symmetric<dim>(a, values);
          };
        }
      if (field.kind == Field::Kind::tensor)
        {
          result.description.n_components = 9;
          result.components               = tensor_components(dim);
          result.append = [field](const Particle<dim> &particle, auto &values) {
            for (unsigned int i = 0; i < 3; ++i)
              for (unsigned int j = 0; j < 3; ++j)
                values.push_back(
                  i < dim && j < dim
                    ? particle.get_properties()[field.offset + dim * i + j]
                    : (i == j ? 1. : 0.));
          };
        }
      return result;
    }

    /** Reads the state of stress of a particle. */
    template <int dim>
    struct StressReader
    {
      unsigned int left_cauchy_green_less_unit, kirchhoff_stress;
      /** Of what acts in place of the particle's own; empty: nothing. */
      std::optional<unsigned int> cell_mean_stress;

      MandelVector<dim>
      tensor(const Particle<dim> &particle, const unsigned int offset) const
      {
        MandelVector<dim> a;
        for (unsigned int c = 0; c < n_mandel<dim>; ++c)
          a[c] = particle.get_properties()[offset + c];
        return a;
      }

      /**
       * tau/J, with J^2 = det b; with the mean stress of the cell where that
       * is what acts.
       */
      MandelVector<dim>
      cauchy_stress(const Particle<dim> &particle) const
      {
        const double volume_change =
          std::sqrt(1. + mandel::determinant_less_one<dim>(
                           tensor(particle, left_cauchy_green_less_unit)));
        const auto own = tensor(particle, kirchhoff_stress) / volume_change;
        if (!cell_mean_stress)
          return own;
        const auto unit = mandel::unit<dim>();
        return own + (particle.get_properties()[*cell_mean_stress] -
                      unit * own / 3.) *
                       unit;
      }

      /** 1/2 ln b of a tensor that is carried as b - I. */
      MandelVector<dim>
      logarithmic_strain(const Particle<dim> &particle,
                         const unsigned int   b_less_unit) const
      {
        const auto e = principal_strain(
          spectral_decomposition<dim>(tensor(particle, b_less_unit)));
        std::array<double, 3> values;
        for (unsigned int i = 0; i < 3; ++i)
          values[i] = 0.5 * e.log_b[i];
        return from_principal(e.b, values);
      }
    };

    /** What follows from stress and deformation. */
    template <int dim>
    std::vector<ParticleField<dim>>
    stress_fields(const FieldLayout &layout)
    {
      const StressReader<dim> read{layout["left_cauchy_green_less_unit"],
                                   layout["kirchhoff_stress"],
                                   layout.has("cell_mean_stress")
                                     ? std::optional<unsigned int>(
                                         layout["cell_mean_stress"])
                                     : std::nullopt};
      const unsigned int      elastic =
        layout.has("elastic_left_cauchy_green_less_unit")
               ? layout["elastic_left_cauchy_green_less_unit"]
               : read.left_cauchy_green_less_unit;
      const auto scalar = [](const std::string &name,
                             const std::string &description,
                             const auto        &value) {
        return ParticleField<dim>{{name, 1, "Pa", description},
                                  [value](const Particle<dim> &particle,
                                          std::vector<double> &values) {
                                    values.push_back(value(particle));
                                  },
                                  {{"", 0}}};
      };
      return {
        {{"cauchy_stress",
          9,
          "Pa",
          "Cauchy stress, force per present area; positive in tension"},
         [read](const Particle<dim> &particle, std::vector<double> &values) {
           append_symmetric<dim>(read.cauchy_stress(particle), values);
         },
         symmetric_components(dim)},
        scalar("pressure",
               "minus the mean normal Cauchy stress; positive in compression",
               [read](const Particle<dim> &particle) {
                 return mandel::unit<dim>() * read.cauchy_stress(particle) /
                        -3.;
               }),
        scalar("von_mises_stress",
               "sqrt(3/2 s:s) of the deviator s of the Cauchy stress",
               [read](const Particle<dim> &particle) {
                 const auto stress = read.cauchy_stress(particle);
                 const auto unit   = mandel::unit<dim>();
                 const auto s      = stress - (unit * stress / 3.) * unit;
                 return std::sqrt(1.5) * s.norm();
               }),
        {{"logarithmic_strain",
          9,
          "1",
          "1/2 ln b, b = F F^T: elastic and plastic strain together"},
         [read](const Particle<dim> &particle, std::vector<double> &values) {
           append_symmetric<dim>(read.logarithmic_strain(
                                   particle, read.left_cauchy_green_less_unit),
                                 values);
         },
         symmetric_components(dim)},
        {{"elastic_strain",
          9,
          "1",
          "1/2 ln b^e: the part of the logarithmic strain that the stress "
          "belongs to"},
         [read, elastic](const Particle<dim> &particle,
                         std::vector<double> &values) {
           append_symmetric<dim>(read.logarithmic_strain(particle, elastic),
                                 values);
         },
         symmetric_components(dim)}};
    }

    Field
    start_field()
    {
      return {start_position_field,
              Field::Kind::vector,
              "m",
              "position at the start of the run"};
    }

    template <int dim>
    ParticleField<dim>
    displacement_field(const FieldLayout &layout)
    {
      const unsigned int start = layout[start_position_field];
      return {{displacement,
               dim,
               "m",
               "from where the particle was at the start of the run"},
              [start](const Particle<dim> &particle, auto &values) {
                for (unsigned int d = 0; d < dim; ++d)
                  values.push_back(particle.get_location()[d] -
                                   particle.get_properties()[start + d]);
              },
              vector_components(dim)};
    }

    /** Throws ExcParameter. */
    void
    refuse(const std::string              &wanted,
           const std::vector<std::string> &known,
           const std::string              &section,
           const std::string              &entry)
    {
      const std::string nearest = nearest_name(wanted, known);
      AssertThrow(false,
                  ExcParameter(section,
                               entry,
                               wanted,
                               (nearest.empty()
                                  ? std::string()
                                  : "did you mean <" + nearest + ">? ") +
                                 "The particles of this scene have " +
                                 join(known) + "."));
    }
  } // namespace

  template <int dim>
  ParticleFields<dim>::ParticleFields(const FieldLayout &layout)
  {
    for (const Field &field : layout.fields())
      fields.push_back(carried<dim>(field));
    if (layout.has("kirchhoff_stress"))
      for (auto &field : stress_fields<dim>(layout))
        fields.push_back(std::move(field));
    if (layout.has(start_position_field))
      fields.push_back(displacement_field<dim>(layout));
  }

  template <int dim>
  std::vector<std::string>
  ParticleFields<dim>::names() const
  {
    std::vector<std::string> result;
    for (const auto &field : fields)
      result.push_back(field.description.name);
    return result;
  }

  template <int dim>
  std::vector<ParticleField<dim>>
  ParticleFields<dim>::find(const std::vector<std::string> &wanted,
                            const std::string              &section,
                            const std::string              &entry) const
  {
    std::vector<ParticleField<dim>> result;
    const auto                      add = [&](const auto &field) {
      const auto is_field = [&field](const auto &other) {
        return other.description.name == field.description.name;
      };
      if (std::none_of(result.begin(), result.end(), is_field))
        result.push_back(field);
    };
    for (const std::string &name : wanted)
      {
        bool is_known = name == "carried";
        for (const auto &field : fields)
          if (name == "carried" ? field.is_carried
                                : field.description.name == name)
            {
              is_known = true;
              add(field);
            }
        if (!is_known)
          {
            auto known = names();
            known.insert(known.begin(), "carried");
            if (std::count(known.begin(), known.end(), displacement) == 0)
              known.push_back(displacement); // for who asks for it
            refuse(name, known, section, entry);
          }
      }
    return result;
  }

  template <int dim>
  ParticleNumber<dim>
  ParticleFields<dim>::number(const std::string &wanted,
                              const std::string &section,
                              const std::string &entry) const
  {
    const auto label = [&wanted](const ParticleField<dim> &field) {
      const std::string unit = field.description.unit;
      return dealii::Utilities::replace_in_string(wanted, "_", " ") +
             (unit.empty() || unit == "1" ? "" : " (" + unit + ")");
    };
    const auto one_of = [](const ParticleField<dim> &field,
                           const unsigned int        position) {
      return [append = field.append, position](const Particle<dim> &particle) {
        std::vector<double> values;
        append(particle, values);
        return values[position];
      };
    };
    std::vector<std::string> known;
    for (const auto &field : fields)
      {
        const std::string &name = field.description.name;
        if (field.description.n_components < 9)
          known.push_back(name);
        if (name == wanted && field.description.n_components == 1)
          return {label(field), one_of(field, 0)};
        if (name == wanted && field.description.n_components == dim)
          return {label(field),
                  [append = field.append](const Particle<dim> &particle) {
                    std::vector<double> values;
                    append(particle, values);
                    double sum = 0.;
                    for (const double value : values)
                      sum += value * value;
                    return std::sqrt(sum);
                  }};
        for (const auto &[ending, position] : field.components)
          if (!ending.empty())
            {
              known.push_back(name + "_" + ending);
              if (known.back() == wanted)
                return {label(field), one_of(field, position)};
            }
      }
    if (std::count(known.begin(), known.end(), displacement) == 0)
      known.push_back(displacement);
    refuse(wanted, known, section, entry);
    return {};
  }

  bool
  wants_displacement(const std::vector<std::string> &names)
  {
    return std::any_of(names.begin(), names.end(), [](const auto &name) {
      return name.compare(0, std::string(displacement).size(), displacement) ==
             0;
    });
  }

  void
  add_start_position(FieldLayout &layout)
  {
    Field field = start_field();
    field.initial.assign(3, std::numeric_limits<double>::quiet_NaN());
    layout.set_effect(output_effect);
    layout.add(field);
  }

  EffectCard
  displacement_card(const bool is_present)
  {
    EffectCard card;
    card.name       = output_effect;
    card.setting    = "Output/Particle fields or Picture field = displacement";
    card.enters     = "nowhere: particles keep where they started";
    card.fields     = {start_field()};
    card.is_present = is_present;
    return card;
  }

  template class ParticleFields<2>;
  template class ParticleFields<3>;
} // namespace emmy
