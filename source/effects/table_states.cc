#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/effects/table_states.h>
#include <emmy/material/principal_axes.h>
#include <emmy/material/stressed_state.h>
#include <emmy/particles/particle_table.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace emmy
{
  namespace
  {
    /** Symmetric tensors, those first that count first. */
    const std::vector<std::string> tensor_names{"elastic_strain",
                                                "kirchhoff_stress",
                                                "cauchy_stress",
                                                "elastic_left_cauchy_green",
                                                "logarithmic_strain",
                                                "left_cauchy_green"};

    template <int dim>
    std::vector<std::string>
    component_names()
    {
      if (dim == 2)
        return {"_xx", "_yy", "_xy", "_zz"};
      return {"_xx", "_yy", "_zz", "_xy", "_xz", "_yz"};
    }

    /** Which columns of a table are what, for a material. */
    template <int dim>
    class StateColumns
    {
    public:
      StateColumns(const ParticleColumns &columns,
                   const Material<dim>   &material,
                   const FieldLayout     &layout)
        : columns(columns)
      {
        for (const std::string &name : tensor_names)
          find_tensor(name);
        for (const Field &field : material.history())
          history.push_back(find_scalar(field.name));
        for (const Field &field : material.parameters())
          parameters.push_back(find_scalar(field.name));
        if (!history.empty())
          dissipation = find_scalar("plastic_dissipation_density");
        if (layout.has(own_volume_field))
          {
            own_volume  = find_scalar(own_volume_field);
            mean_stress = find_scalar("cell_mean_stress");
          }
        find_elastic();
        sort_others(layout);
        for (const Field &field : material.history())
          if (columns.find(field.name) < 0)
            virgin.push_back(field.name);
        if (elastic.empty())
          virgin.insert(virgin.begin(), "stress");
      }

      /** A tensor of a row; @p unit is taken off. */
      MandelVector<dim>
      tensor(const std::string         &name,
             const std::vector<double> &row,
             const bool                 less_unit = false) const
      {
        const auto       &places = tensors.at(name);
        MandelVector<dim> result;
        for (unsigned int c = 0; c < n_mandel<dim>; ++c)
          {
            const bool is_normal = mandel::unit<dim>()[c] > 0.;
            result[c] = places[c] < 0 ? (less_unit && is_normal ? 1. : 0.)
                                      : row[places[c]];
            if (!is_normal)
              result[c] *= mandel::sqrt2;
            else if (less_unit)
              result[c] -= 1.;
          }
        return result;
      }

      std::string      elastic; ///< tensor of the elastic state; empty: none
      std::string      total; ///< of all deformation; empty: as the elastic one
      std::vector<int> history, parameters; ///< columns; -1: none
      int              dissipation = -1, own_volume = -1, mean_stress = -1;
      std::vector<std::string> taken, virgin, unused, refused;

    private:
      int
      find_scalar(const std::string &name)
      {
        const int column = columns.find(name);
        if (column >= 0)
          {
            known.insert(name);
            taken.push_back(name);
          }
        return column;
      }

      void
      find_tensor(const std::string &name)
      {
        std::array<int, n_mandel<dim>> places;
        bool                           is_there = false;
        const auto                     endings  = component_names<dim>();
        for (unsigned int c = 0; c < n_mandel<dim>; ++c)
          {
            places[c] = columns.find(name + endings[c]);
            is_there |= places[c] >= 0;
          }
        if (!is_there)
          return;
        tensors[name] = places;
        for (const char *ending : {"_xx", "_yy", "_zz", "_xy", "_xz", "_yz"})
          known.insert(name + ending);
        // the zz of plane strain may be left out only of strains
        for (unsigned int c = 0; c < n_mandel<dim>; ++c)
          if (places[c] < 0 &&
              (endings[c] != "_zz" || name.find("stress") != std::string::npos))
            refused.push_back(name + " without " + name + endings[c]);
      }

      void
      find_elastic()
      {
        const bool flows = !history.empty();
        for (const std::string &name : tensor_names)
          if (tensors.count(name) > 0)
            {
              const bool is_total =
                name == "logarithmic_strain" || name == "left_cauchy_green";
              if (is_total && flows)
                total = total.empty() ? name : total;
              else if (elastic.empty())
                elastic = name;
              else if (!(is_total && total.empty()))
                unused.push_back(name);
            }
        if (!elastic.empty())
          taken.insert(taken.begin(), elastic);
        if (!total.empty())
          taken.push_back(total);
      }

      /** What follows from others, or is of effects that begin anew. */
      void
      sort_others(const FieldLayout &layout)
      {
        std::set<std::string> idle{"id",
                                   "pressure",
                                   "von_mises_stress",
                                   "displacement",
                                   "strain_energy_density",
                                   "half_length",
                                   "deformation_gradient",
                                   "grid_velocity",
                                   "grid_velocity_gradient"};
        if (!history.empty())
          idle.insert("hardening_energy_density");
        for (const Field &field : layout.fields())
          if (field.asked_by.rfind("material", 0) != 0)
            idle.insert(field.written_name());
        const auto stem = [](const std::string &name) {
          const auto end = name.rfind('_');
          return end != std::string::npos &&
                     name.find_first_not_of("xyz", end + 1) == std::string::npos
                   ? name.substr(0, end)
                   : name;
        };
        for (const std::string &name : columns.names)
          if (known.count(name) == 0)
            {
              bool is_idle = idle.count(name) > 0 || idle.count(stem(name)) > 0;
              // zeros say nothing, as of another body's material
              const unsigned int c = columns.find(name);
              is_idle = is_idle || std::all_of(columns.rows.begin(),
                                               columns.rows.end(),
                                               [c](const auto &row) {
                                                 return row[c] == 0.;
                                               });
              auto             &list = is_idle ? unused : refused;
              const std::string word = is_idle ? stem(name) : name;
              if (std::count(list.begin(), list.end(), word) == 0)
                list.push_back(word);
            }
      }

      const ParticleColumns                                &columns;
      std::map<std::string, std::array<int, n_mandel<dim>>> tensors;
      std::set<std::string>                                 known;
    };

    /** b - I of a logarithmic strain 1/2 ln b. */
    template <int dim>
    MandelVector<dim>
    from_logarithmic(const MandelVector<dim> &strain)
    {
      const SpectralDecomposition<dim> axes =
        spectral_decomposition<dim>(strain);
      std::array<double, 3> values;
      for (unsigned int i = 0; i < 3; ++i)
        values[i] = std::expm1(2. * axes.values[i]);
      return from_principal(axes, values);
    }

    /** A row, as the material sees it. */
    template <int dim>
    struct RowState
    {
      StressedState<dim>  elastic;
      MandelVector<dim>   total_less_unit;
      double              volume_ratio = 1.;
      std::vector<double> parameters;
      double              dissipation = 0.;
      /** det F - 1 of its own motion, and the mean stress of its cell, Pa. */
      double own_volume = 0., mean_stress = 0.;
    };

    template <int dim>
    RowState<dim>
    state_of_row(const StateColumns<dim>   &columns,
                 const std::vector<double> &row,
                 const Material<dim>       &material,
                 std::vector<double>        parameters)
    {
      RowState<dim> result;
      for (unsigned int i = 0; i < parameters.size(); ++i)
        if (columns.parameters[i] >= 0)
          parameters[i] = row[columns.parameters[i]];
      result.parameters = parameters;
      std::vector<double> history;
      for (const int column : columns.history)
        history.push_back(column < 0 ? 0. : row[column]);
      double J = 0.; // unknown
      if (!columns.total.empty())
        {
          result.total_less_unit =
            columns.total == "logarithmic_strain"
              ? from_logarithmic<dim>(columns.tensor(columns.total, row))
              : columns.tensor(columns.total, row, true);
          J = std::sqrt(
            1. + mandel::determinant_less_one<dim>(result.total_less_unit));
        }
      const std::string &name = columns.elastic;
      if (name.find("stress") != std::string::npos)
        result.elastic =
          stressed_state(material,
                         parameters,
                         GivenStress<dim>{columns.tensor(name, row),
                                          name == "kirchhoff_stress",
                                          J,
                                          history});
      else
        {
          MandelVector<dim> b;
          if (!name.empty())
            b = name.find("strain") != std::string::npos
                  ? from_logarithmic<dim>(columns.tensor(name, row))
                  : columns.tensor(name, row, true);
          result.elastic = strained_state(material, parameters, b, history);
        }
      if (columns.total.empty())
        result.total_less_unit = result.elastic.left_cauchy_green_less_unit;
      result.volume_ratio = std::sqrt(
        1. + mandel::determinant_less_one<dim>(result.total_less_unit));
      const auto given = [&row](const int column, const double otherwise) {
        return column < 0 ? otherwise : row[column];
      };
      result.dissipation = given(columns.dissipation, 0.);
      result.own_volume  = given(columns.own_volume, result.volume_ratio - 1.);
      result.mean_stress =
        given(columns.mean_stress,
              mandel::unit<dim>() * result.elastic.kirchhoff_stress / 3. /
                result.volume_ratio);
      return result;
    }

    template <int dim>
    void
    set_row(const RowState<dim>                      &state,
            const Material<dim>                      &material,
            const FieldLayout                        &layout,
            dealii::Particles::ParticleAccessor<dim> &particle)
    {
      const auto properties = particle.get_properties();
      const auto set        = [&](const char *field, const auto &tensor) {
        for (unsigned int c = 0; c < n_mandel<dim>; ++c)
          properties[layout[field] + c] = tensor[c];
      };
      const auto &elastic = state.elastic;
      set("left_cauchy_green_less_unit", state.total_less_unit);
      set("kirchhoff_stress", elastic.kirchhoff_stress);
      properties[layout["strain_energy_density"]] = elastic.stored_energy;
      properties[layout["reference_volume"]] /= state.volume_ratio;
      if (layout.has("elastic_left_cauchy_green_less_unit"))
        set("elastic_left_cauchy_green_less_unit",
            elastic.left_cauchy_green_less_unit);
      const auto history = material.history();
      for (unsigned int i = 0; i < history.size(); ++i)
        properties[layout[history[i].name]] = elastic.history[i];
      if (!history.empty())
        {
          properties[layout["hardening_energy_density"]] =
            elastic.hardening_energy;
          properties[layout["plastic_dissipation_density"]] = state.dissipation;
        }
      const auto parameters = material.parameters();
      for (unsigned int i = 0; i < parameters.size(); ++i)
        properties[layout[parameters[i].name]] = state.parameters[i];
      if (layout.has(own_volume_field))
        {
          properties[layout[own_volume_field]]   = state.own_volume;
          properties[layout["cell_mean_stress"]] = state.mean_stress;
        }
    }

    /** Columns that nobody wants; empty: none. */
    template <int dim>
    std::string
    refusal(const Body<dim>         &body,
            const Material<dim>     &material,
            const StateColumns<dim> &columns)
    {
      if (columns.refused.empty())
        return body.initial_stress
                 ? "body <" + body.name +
                     "> has an Initial stress, and a table with states"
                 : "";
      std::vector<std::string> known = tensor_names;
      if (material.history().empty())
        known.erase(known.begin() + 3);
      for (const auto &list : {material.history(), material.parameters()})
        for (const Field &field : list)
          known.push_back(field.name);
      return "body <" + body.name + "> has no use for the columns " +
             join(columns.refused) + " of <" + body.shape->table()->from.file +
             ">. Of its material a table can say: " + join(known) +
             ", of tensors with all components " + join(component_names<dim>());
    }
  } // namespace

  template <int dim>
  bool
  has_table_state(const Body<dim> &body)
  {
    const auto *const table = body.shape->table();
    return table && !table->state.names.empty();
  }

  template <int dim>
  std::vector<std::string>
  set_table_states(const std::vector<Body<dim>>             &bodies,
                   const std::vector<const Material<dim> *> &material_of_body,
                   const FieldLayout                        &layout,
                   const FilledRows                         &filled,
                   const MPI_Comm                            communicator,
                   dealii::Particles::ParticleHandler<dim>  &particles)
  {
    std::vector<std::string>                  notes;
    std::map<unsigned int, StateColumns<dim>> columns;
    for (unsigned int b = 0; b < bodies.size(); ++b)
      if (has_table_state(bodies[b]))
        {
          const auto &of =
            columns
              .emplace(b,
                       StateColumns<dim>(bodies[b].shape->table()->state,
                                         *material_of_body[b],
                                         layout))
              .first->second;
          throw_together(communicator,
                         "Bodies",
                         refusal(bodies[b], *material_of_body[b], of),
                         "correct the file, or name columns that shall not "
                         "count in <Leave out>.");
          const std::string who = "body " + bodies[b].name;
          if (!of.taken.empty())
            notes.push_back(who + ": from its table " + join(of.taken));
          if (!of.virgin.empty())
            notes.push_back(who + ": as in a virgin body: " + join(of.virgin));
          if (!of.unused.empty())
            notes.push_back(who +
                            ": columns that do not count: " + join(of.unused));
        }
      else if (bodies[b].shape->table() && !bodies[b].initial_stress)
        notes.push_back("body " + bodies[b].name +
                        ": its table has no state; it is as a virgin body");

    std::string wrong;
    for (auto &particle : particles)
      {
        const unsigned int b     = particle.get_properties()[layout["body"]];
        const auto         found = columns.find(b);
        if (found == columns.end() || !wrong.empty())
          continue;
        const auto &of    = found->second;
        const auto &table = *bodies[b].shape->table();
        const auto &row =
          table.state.rows[filled.rows[particle.get_id() - filled.first_id]];
        const auto &material = *material_of_body[b];
        const auto  state    = state_of_row(
          of, row, material, material.parameters_at(particle.get_location()));
        if (!state.elastic.is_found || !(state.volume_ratio > 0.))
          wrong = "the material of body <" + bodies[b].name +
                  "> does not bear the state of the particle at (" +
                  dealii::Patterns::Tools::to_string(particle.get_location()) +
                  ") m in <" + table.from.file + "> without flow";
        else
          set_row(state, material, layout, particle);
      }
    throw_together(communicator,
                   "Bodies",
                   wrong,
                   "give its plastic strain too, or raise the strength.");
    return notes;
  }

  template <int dim>
  double
  total_energy(const std::string                             &density,
               const FieldLayout                             &layout,
               const MPI_Comm                                 communicator,
               const dealii::Particles::ParticleHandler<dim> &particles)
  {
    const unsigned int volume = layout["reference_volume"],
                       energy = layout[density];
    double sum                = 0.;
    for (const auto &particle : particles)
      sum +=
        particle.get_properties()[volume] * particle.get_properties()[energy];
    return dealii::Utilities::MPI::sum(sum, communicator);
  }

#define INSTANTIATE(dim)                                                     \
  template bool                     has_table_state<dim>(const Body<dim> &); \
  template std::vector<std::string> set_table_states<dim>(                   \
    const std::vector<Body<dim>> &,                                          \
    const std::vector<const Material<dim> *> &,                              \
    const FieldLayout &,                                                     \
    const FilledRows &,                                                      \
    const MPI_Comm,                                                          \
    dealii::Particles::ParticleHandler<dim> &);                              \
  template double total_energy<dim>(                                         \
    const std::string &,                                                     \
    const FieldLayout &,                                                     \
    const MPI_Comm,                                                          \
    const dealii::Particles::ParticleHandler<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
