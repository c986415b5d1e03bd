#include <emmy/base/exceptions.h>
#include <emmy/base/parameter_file.h>
#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/run/saved_run.h>
#include <emmy/run/start.h>
#include <emmy/transfer/particle_parcel.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace emmy
{
  namespace
  {
    /** Where each component of a particle comes from. */
    struct FieldMap
    {
      static constexpr unsigned int none =
        dealii::numbers::invalid_unsigned_int;

      std::vector<unsigned int> old_component; ///< none: a virgin's
      std::vector<std::string>  virgin, left;
    };

    FieldMap
    map_fields(const SavedRun                 &saved,
               const FieldLayout              &layout,
               const std::vector<std::string> &effects)
    {
      FieldMap result;
      result.old_component.assign(layout.n_components(), FieldMap::none);
      for (const Field &field : layout.fields())
        {
          unsigned int offset   = 0;
          bool         is_taken = false;
          // effects choose their particles anew
          const bool is_of_effect =
            std::count(effects.begin(), effects.end(), field.asked_by) > 0;
          for (const auto &[name, n_components] : saved.fields)
            {
              is_taken = name == field.name &&
                         n_components == field.n_components && !is_of_effect;
              if (is_taken)
                break;
              offset += n_components;
            }
          for (unsigned int c = 0; is_taken && c < field.n_components; ++c)
            result.old_component[field.offset + c] = offset + c;
          if (!is_taken)
            result.virgin.push_back(field.name);
        }
      for (const auto &[name, n_components] : saved.fields)
        if (!layout.has(name))
          result.left.push_back(name);
      return result;
    }

    /** The number of each body of then among those of now. */
    template <int dim>
    std::vector<unsigned int>
    map_bodies(const SavedRun &saved, const std::vector<Body<dim>> &bodies)
    {
      const auto then = dealii::Utilities::split_string_list(
        ParameterFile::from_text(saved.parameters, saved.path)
          .value("Bodies/Names", ""));
      std::vector<std::string> now;
      for (const Body<dim> &body : bodies)
        now.push_back(body.name);
      AssertThrow(then.size() == now.size() &&
                    std::is_permutation(then.begin(), then.end(), now.begin()),
                  ExcParameter("Start",
                               "From",
                               saved.directory,
                               "the bodies of that run are " + join(then) +
                                 ", and those of this scene " + join(now) +
                                 ". Give Bodies/Names the same names."));
      std::vector<unsigned int> result;
      for (const std::string &name : then)
        result.push_back(std::find(now.begin(), now.end(), name) - now.begin());
      return result;
    }

    template <int dim>
    SavedRun
    read(const StartParameters &parameters, const MPI_Comm communicator)
    {
      SavedRun saved =
        parameters.step == 0
          ? read_saved_run(parameters.from, communicator, "Start")
          : read_saved_run(parameters.from,
                           communicator,
                           "Start",
                           parameters.step);
      AssertThrow(parameters.step == 0 || saved.step == parameters.step,
                  ExcParameter("Start",
                               "Step",
                               std::to_string(parameters.step),
                               "there is no checkpoint of it in <" +
                                 parameters.from +
                                 "> that can be used; the last before it is "
                                 "of step " +
                                 std::to_string(saved.step) + "."));
      AssertThrow(saved.dimension == dim,
                  ExcParameter("Start",
                               "From",
                               parameters.from,
                               "that run has " +
                                 std::to_string(saved.dimension) +
                                 " dimensions, and this scene " +
                                 std::to_string(dim) + "."));
      return saved;
    }
  } // namespace

  StartParameters::StartParameters()
    : Section("Start")
  {
    add_parameter("From",
                  from,
                  "Results of a run with checkpoints. The bodies, which have "
                  "the same names there, are not filled, but come from the "
                  "state of that run; time begins at 0. Empty: they are "
                  "filled.");
    add_parameter("Step",
                  step,
                  "The step of that run whose state it is. 0: the last one "
                  "that there is.",
                  prm,
                  dealii::Patterns::Integer(0));
  }

  void
  StartParameters::validate(const std::string &output_directory) const
  {
    std::error_code ignored;
    AssertThrow(from.empty() ||
                  !std::filesystem::equivalent(from, output_directory, ignored),
                ExcParameter(path(),
                             "From",
                             from,
                             "Output/Directory is the same folder. Write the "
                             "results of this scene to another one."));
  }

  template <int dim>
  StartedFrom
  start_from(const StartParameters                   &parameters,
             const std::vector<Body<dim>>            &bodies,
             const std::vector<std::string>          &effects,
             const FieldLayout                       &layout,
             BackgroundGrid<dim>                     &grid,
             dealii::Particles::ParticleHandler<dim> &particles)
  {
    const SavedRun     saved      = read<dim>(parameters, grid.communicator());
    const FieldMap     fields     = map_fields(saved, layout, effects);
    const auto         new_bodies = map_bodies(saved, bodies);
    const unsigned int body       = layout["body"];
    const std::vector<double> virgin = layout.initial_values();

    const Parcel<dim>                    old = particles_of<dim>(saved);
    Parcel<dim>                          parcel(layout.n_components());
    std::map<CellKey<dim>, unsigned int> n_points;
    std::string                          outside;
    const auto add = [&parcel](const auto first, const auto last) {
      parcel.values.insert(parcel.values.end(), first, last);
    };
    for (std::size_t i = 0; i < old.n_particles(); ++i)
      {
        const double      *from = &old.values[i * old.n_numbers() + dim];
        dealii::Point<dim> x;
        std::copy_n(from, dim, x.begin_raw());
        if (!grid.contains(x) && outside.empty())
          outside = "a particle at (" + dealii::Patterns::Tools::to_string(x) +
                    ") m is outside of the grid";
        const CellKey<dim> place = grid.key_of(x);
        ++n_points[place];
        add(place.begin(), place.end());
        add(from, from + dim + 1); // position and id
        std::vector<double> values = virgin;
        for (unsigned int c = 0; c < values.size(); ++c)
          if (fields.old_component[c] != FieldMap::none)
            values[c] = from[dim + 1 + fields.old_component[c]];
        values[body] = new_bodies[static_cast<unsigned int>(values[body])];
        const unsigned int half =
          layout.has("half_length") ? layout["half_length"] : 0;
        if (layout.has("half_length") &&
            fields.old_component[half] == FieldMap::none)
          for (unsigned int d = 0; d < dim; ++d)
            values[half + d] =
              initial_half_length(bodies[values[body]], grid)[d];
        add(values.begin(), values.end());
      }
    throw_together(grid.communicator(),
                   "Start",
                   outside,
                   "enlarge the grid (Grid/Lower corner, Upper corner).");
    grid.cover({n_points.begin(), n_points.end()});
    particles.initialize(grid.triangulation(),
                         grid.mapping(),
                         layout.n_components());
    particles.reserve(parcel.n_particles());
    deliver(parcel, grid, particles);

    StartedFrom result;
    result.path        = saved.path;
    result.stored      = stored_energies<dim>(saved);
    result.notes       = {"started from step " + std::to_string(saved.step) +
                          ", t = " + brief(saved.time) + " s of <" + parameters.from +
                          ">, with its energies"};
    auto virgin_fields = fields.virgin; // but for those that follow from others
    for (const char *const field : {own_volume_field, cell_mean_stress_field})
      if (const auto found =
            std::find(virgin_fields.begin(), virgin_fields.end(), field);
          found != virgin_fields.end())
        {
          virgin_fields.erase(found);
          result.lacks_cell_states = true;
        }
    if (!virgin_fields.empty())
      result.notes.push_back("as in a virgin body: " + join(virgin_fields));
    if (!fields.left.empty())
      result.notes.push_back("left behind: " + join(fields.left));
    return result;
  }

  void
  keep_start(const StartedFrom  &started,
             const RunDirectory &directory,
             const MPI_Comm      communicator)
  {
    namespace fs = std::filesystem;
    std::string problem;
    if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
      {
        const fs::path from = started.path,
                       to = fs::path(directory.file("start")) / "checkpoints" /
                            from.filename();
        std::error_code error;
        fs::create_directories(to, error);
        if (!error)
          fs::copy(from,
                   to,
                   fs::copy_options::recursive |
                     fs::copy_options::overwrite_existing,
                   error);
        if (error)
          problem = cannot_write(to.string(), error.value());
      }
    throw_together(communicator, "Output", problem, file_remedy);
  }

#define INSTANTIATE(dim)                \
  template StartedFrom start_from<dim>( \
    const StartParameters &,            \
    const std::vector<Body<dim>> &,     \
    const std::vector<std::string> &,   \
    const FieldLayout &,                \
    BackgroundGrid<dim> &,              \
    dealii::Particles::ParticleHandler<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
