#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/initial_states.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/material/stressed_state.h>
#include <emmy/math/spectral.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace emmy
{
  namespace
  {
    template <int dim>
    using Particle = dealii::Particles::ParticleAccessor<dim>;

    template <int dim>
    std::string
    place_of(const Body<dim> &body, const Particle<dim> &particle)
    {
      return " of body <" + body.name + "> at (" +
             dealii::Patterns::Tools::to_string(particle.get_location()) +
             ") m";
    }

    /** Write the parameters. @return what is wrong, if anything */
    template <int dim>
    std::string
    set_parameters(const Body<dim>           &body,
                   const std::vector<Field>  &fields,
                   const std::vector<double> &values,
                   const FieldLayout         &layout,
                   Particle<dim>             &particle)
    {
      for (unsigned int i = 0; i < fields.size(); ++i)
        {
          particle.get_properties()[layout[fields[i].name]] = values[i];
          if (!(values[i] > 0. && std::isfinite(values[i])))
            return "the " + fields[i].name + place_of(body, particle) + " is " +
                   shortest(values[i]) + ", and must be positive";
        }
      return "";
    }

    /** Write a state. */
    template <int dim>
    void
    set_state(const StressedState<dim> &state,
              const FieldLayout        &layout,
              Particle<dim>            &particle)
    {
      const auto properties = particle.get_properties();
      const auto set        = [&](const char *field, const auto &tensor) {
        for (unsigned int c = 0; c < n_mandel<dim>; ++c)
          properties[layout[field] + c] = tensor[c];
      };
      set("left_cauchy_green_less_unit", state.left_cauchy_green_less_unit);
      set("kirchhoff_stress", state.kirchhoff_stress);
      properties[layout["strain_energy_density"]] = state.stored_energy;
      properties[layout["reference_volume"]] /= state.volume_ratio;
      if (layout.has("elastic_left_cauchy_green_less_unit"))
        set("elastic_left_cauchy_green_less_unit",
            state.left_cauchy_green_less_unit);
    }
  } // namespace

  template <int dim>
  void
  set_initial_states(const std::vector<Body<dim>>             &bodies,
                     const std::vector<const Material<dim> *> &material_of_body,
                     const FieldLayout                        &layout,
                     const MPI_Comm                            communicator,
                     dealii::Particles::ParticleHandler<dim>  &particles)
  {
    std::vector<std::vector<Field>> fields;
    bool                            is_needed = false;
    for (unsigned int b = 0; b < bodies.size(); ++b)
      {
        fields.push_back(material_of_body[b]->parameters());
        is_needed |= !fields[b].empty() || bodies[b].initial_stress;
      }
    if (!is_needed)
      return;

    const unsigned int body_component = layout["body"];
    std::string        wrong_parameter, wrong_stress;
    for (auto &particle : particles)
      {
        const unsigned int b        = particle.get_properties()[body_component];
        const Body<dim>   &body     = bodies[b];
        const auto        &material = *material_of_body[b];
        const auto values = material.parameters_at(particle.get_location());
        if (std::string problem =
              set_parameters(body, fields[b], values, layout, particle);
            !problem.empty())
          {
            wrong_parameter = std::move(problem);
            break;
          }
        if (!body.initial_stress)
          continue;
        const auto stress = body.initial_stress->at(particle.get_location());
        const auto state  = stressed_state(material, values, stress);
        if (!state.is_found)
          {
            wrong_stress =
              "the material does not bear the Initial stress" +
              place_of(body, particle) + " without flow: its mean is " +
              brief(mandel::unit<dim>() * stress / 3.) + " Pa, the largest " +
              "difference " + brief([&] {
                const auto values = spectral_decomposition<dim>(stress).values;
                return *std::max_element(values.begin(), values.end()) -
                       *std::min_element(values.begin(), values.end());
              }()) +
              " Pa";
            break;
          }
        set_state(state, layout, particle);
      }
    throw_together(communicator,
                   "Materials",
                   wrong_parameter,
                   "correct the formula of the factor.");
    throw_together(communicator,
                   "Bodies",
                   wrong_stress,
                   "choose a K0 or a <Stress> within its strength, or raise "
                   "its strength.");
    set_cell_states(material_of_body, layout, particles);
  }

  template <int dim>
  void
  set_cell_states(const std::vector<const Material<dim> *> &material_of_body,
                  const FieldLayout                        &layout,
                  dealii::Particles::ParticleHandler<dim>  &particles)
  {
    if (!layout.has(own_volume_field))
      return;
    const unsigned int body        = layout["body"],
                       own_volume  = layout[own_volume_field],
                       mean_stress = layout[cell_mean_stress_field],
                       stress      = layout["kirchhoff_stress"],
                       strain      = layout["left_cauchy_green_less_unit"],
                       volume      = layout["reference_volume"];
    struct Sums
    {
      double volume = 0., stress = 0.; // sum V0 J, sum V0 tr tau/3
    };
    std::map<std::pair<unsigned int, const Material<dim> *>, Sums> cells;
    const auto sums_of = [&](const Particle<dim> &particle) -> Sums & {
      return cells[{particle.get_surrounding_cell()->active_cell_index(),
                    material_of_body[particle.get_properties()[body]]}];
    };
    const auto tensor = [](const auto &properties, const unsigned int offset) {
      MandelVector<dim> a;
      for (unsigned int c = 0; c < n_mandel<dim>; ++c)
        a[c] = properties[offset + c];
      return a;
    };
    for (auto &particle : particles)
      {
        const auto   properties = particle.get_properties();
        const double J          = std::sqrt(
          1. + mandel::determinant_less_one<dim>(tensor(properties, strain)));
        properties[own_volume] = J - 1.;
        Sums &sums             = sums_of(particle);
        sums.volume += properties[volume] * J;
        sums.stress += properties[volume] *
                       (mandel::unit<dim>() * tensor(properties, stress)) / 3.;
      }
    for (auto &particle : particles)
      {
        const Sums &sums                       = sums_of(particle);
        particle.get_properties()[mean_stress] = sums.stress / sums.volume;
      }
  }

#define INSTANTIATE(dim)                        \
  template void set_initial_states<dim>(        \
    const std::vector<Body<dim>> &,             \
    const std::vector<const Material<dim> *> &, \
    const FieldLayout &,                        \
    const MPI_Comm,                             \
    dealii::Particles::ParticleHandler<dim> &); \
  template void set_cell_states<dim>(           \
    const std::vector<const Material<dim> *> &, \
    const FieldLayout &,                        \
    dealii::Particles::ParticleHandler<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
