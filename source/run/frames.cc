#include <emmy/output/data_file.h>
#include <emmy/output/particle_csv.h>
#include <emmy/run/frames.h>

#include <algorithm>
#include <cstdio>

namespace emmy
{
  namespace
  {
    /** More particles than this are thinned out in pictures. */
    constexpr std::size_t max_drawn_particles = 200000,
                          max_film_particles  = 3000;

    template <int dim>
    std::vector<double>
    default_picture_times(const double end_time)
    {
      std::vector<double> times;
      for (unsigned int i = 0; i < 5; ++i) // finish() adds the end
        times.push_back(end_time * i / 5.);
      return times;
    }
  } // namespace

  template <int dim>
  Frames<dim>::Frames(Scene<dim>                 &scene,
                      const SceneParameters<dim> &parameters,
                      const RunDirectory         &directory)
    : scene(scene)
    , state(scene.state.frames)
    , wanted(parameters.output)
    , end_time(parameters.time.end_time)
    , directory(directory)
    , communicator(scene.grid.communicator())
    , is_first(dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
    , pictures(wanted.pictures
                 ? std::make_unique<Pictures>(directory.path(),
                                              parameters.general.title.empty()
                                                ? directory.path()
                                                : parameters.general.title)
                 : nullptr)
    , animation(wanted.report
                  ? std::make_unique<Animation>(dim,
                                                scene.drawn_number.label,
                                                state.film)
                  : nullptr)
    , particle_series(directory.path(),
                      "particles",
                      communicator,
                      &state.particle_files)
    , grid_series(directory.path(), "grid", communicator, &state.grid_files)
    , surface_series(directory.path(),
                     "surfaces",
                     communicator,
                     &state.surface_files)
    , picture_times(wanted.picture_times.empty()
                      ? default_picture_times<dim>(end_time)
                      : wanted.picture_times)
  {
    std::sort(picture_times.begin(), picture_times.end());
  }

  template <int dim>
  void
  Frames<dim>::initial()
  {
    state.film_label = scene.drawn_number.label;
    // the grid has no motion yet, so there is no grid file
    if (wanted.frames > 0)
      write_files(0., /*with_grid=*/false);
    while (state.n_pictures < picture_times.size() &&
           picture_times[state.n_pictures] <= 0.)
      ++state.n_pictures;
    if (pictures && state.n_pictures > 0)
      take_picture(0.);
  }

  template <int dim>
  unsigned int
  Frames<dim>::intervals_until(const double time) const
  {
    return static_cast<unsigned int>(
      wanted.frames * std::min(1., time / end_time * (1. + 1e-12)));
  }

  template <int dim>
  void
  Frames<dim>::go_on(const bool is_at_end)
  {
    std::vector<FramesState> &before_end = scene.state.frames_before_end;
    if (!is_at_end && !before_end.empty())
      {
        state = before_end[0];
        before_end.clear();
      }
    // the same as before, unless the times that are wanted are others
    state.n_intervals = intervals_until(scene.state.time);
    state.n_pictures  = std::upper_bound(picture_times.begin(),
                                        picture_times.end(),
                                        state.reached) -
                       picture_times.begin();
    if (pictures && !state.pictures.empty())
      pictures->recall(state.pictures);
    if (state.film_label != scene.drawn_number.label) // another field is drawn
      state.film.clear();
    state.film_label = scene.drawn_number.label;
    if (is_first)
      directory.remove_frames_from(state.n_frames);
    particle_series.write();
    grid_series.write();
    surface_series.write();
  }

  template <int dim>
  void
  Frames<dim>::after(const StepReport &report)
  {
    const auto         scope = scene.phases.scope("output");
    const unsigned int due   = intervals_until(report.time);
    has_grid                 = true;
    if (due > state.n_intervals)
      {
        state.n_intervals = due;
        write_files(report.time, /*with_grid=*/true);
      }
    // the step that ends nearest to a wanted time
    state.reached                = report.time + 0.5 * report.time_step;
    const auto n_pictures_so_far = state.n_pictures;
    while (state.n_pictures < picture_times.size() &&
           picture_times[state.n_pictures] <= state.reached)
      ++state.n_pictures;
    if (pictures && state.n_pictures > n_pictures_so_far)
      take_picture(report.time);
  }

  template <int dim>
  std::vector<std::string>
  Frames<dim>::finish(const StepReport &last, const bool is_complete)
  {
    const auto scope = scene.phases.scope("pictures");
    write_last(last, is_complete);
    return is_first && pictures ? pictures->draw(scene.drawn_number.label)
                                : std::vector<std::string>();
  }

  template <int dim>
  void
  Frames<dim>::at_end(const StepReport &last)
  {
    const auto scope              = scene.phases.scope("output");
    scene.state.frames_before_end = {state};
    write_last(last, /*is_complete=*/true);
  }

  template <int dim>
  void
  Frames<dim>::write_last(const StepReport &last, const bool is_complete)
  {
    if (wanted.frames > 0 && state.last_frame < last.time)
      write_files(last.time, /*with_grid=*/is_complete && has_grid);
    if (pictures && state.last_picture < last.time &&
        wanted.picture_times.empty())
      take_picture(last.time);
  }

  template <int dim>
  void
  Frames<dim>::write_files(const double time, const bool with_grid)
  {
    if (wanted.particle_files)
      write_particles(time);
    if (wanted.particle_tables)
      {
        char number[16];
        std::snprintf(number, sizeof number, "%04u", state.n_frames);
        write_particle_csv<dim>(directory.file(std::string("particles_") +
                                               number + ".csv"),
                                scene.layout,
                                scene.particles,
                                communicator);
      }
    if (wanted.grid_files && with_grid)
      write_grid(time);
    if (wanted.particle_files)
      write_surfaces(time);
    if (animation)
      {
        const Drawn drawn = gather_drawn(max_film_particles);
        if (is_first)
          animation->add<dim>(time,
                              drawn.positions,
                              drawn.values,
                              surfaces(time));
      }
    state.last_frame = time;
    ++state.n_frames;
  }

  template <int dim>
  void
  Frames<dim>::write_particles(const double time)
  {
    std::vector<FieldDescription> fields{
      {"id", 1, "1", "particle id", /*is_integer=*/true}};
    for (const ParticleField<dim> &field : scene.written_fields)
      fields.push_back(field.description);

    DataFile<0, dim> file(fields);
    file.reserve(scene.particles.n_locally_owned_particles());
    std::vector<double> values;
    for (const auto &particle : scene.particles)
      {
        values.assign(1, particle.get_id());
        for (const ParticleField<dim> &field : scene.written_fields)
          field.append(particle, values);
        file.add_point(particle.get_location(),
                       dealii::ArrayView<const double>(values.data(),
                                                       values.size()));
      }
    const std::string name = file.write(
      directory.path(), "particles", state.n_frames, time, communicator);
    particle_series.add(time, name);
  }

  template <int dim>
  void
  Frames<dim>::write_grid(const double time)
  {
    const GridStart<dim>  &start        = scene.stepper->grid_start();
    const ActiveGrid<dim> &active       = *start.active;
    const auto             old_velocity = active.to_local(start.velocity);
    const auto new_velocity = active.to_local(scene.stepper->grid_velocity());
    const auto mass         = scene.stepper->nodal_mass();

    std::vector<FieldDescription> fields{
      {"velocity_old", dim, "m/s", "velocity at the start of the step"},
      {"velocity_new", dim, "m/s", "velocity at the end of the step"},
      {"mass", 1, "kg", "nodal mass, sum of S m"}};
    const StepDiagnosis<dim> *diagnosis = scene.stepper->diagnosis();
    if (diagnosis)
      for (const std::string name : {"mass", "jacobian"})
        fields.push_back({name + "_weakness",
                          1,
                          "1",
                          "how far the vector that the scaled " + name +
                            " matrix sees least goes here; 1: the weakest"});
    const bool has_fields = scene.grid.fields().size() > 1;
    if (has_fields)
      fields.push_back({"field",
                        1,
                        "1",
                        "velocity field; where several have particles, cells "
                        "lie on one another",
                        /*is_integer=*/true});
    DataFile<dim, dim> file(fields);
    file.reserve(active.cells().size());
    std::vector<double> values;
    for (unsigned int cell = 0; cell < active.cells().size(); ++cell)
      {
        std::array<dealii::Point<dim>, BackgroundGrid<dim>::nodes_per_cell>
          vertices;
        values.clear();
        for (unsigned int v = 0; v < vertices.size(); ++v)
          {
            const unsigned int node = active.cell_nodes(cell)[v];
            vertices[v]             = active.position(node);
            for (unsigned int c = 0; c < dim; ++c)
              values.push_back(old_velocity[unknown<dim>(node, c)]);
            for (unsigned int c = 0; c < dim; ++c)
              values.push_back(new_velocity[unknown<dim>(node, c)]);
            values.push_back(mass[node]);
            if (diagnosis)
              values.insert(values.end(),
                            {diagnosis->mass.weakness[node],
                             diagnosis->jacobian.weakness[node]});
            if (has_fields)
              values.push_back(active.cells()[cell].field);
          }
        file.add_cell(vertices,
                      dealii::ArrayView<const double>(values.data(),
                                                      values.size()));
      }
    const std::string name =
      file.write(directory.path(), "grid", state.n_frames, time, communicator);
    grid_series.add(time, name);
  }

  template <int dim>
  std::vector<Surface<dim>>
  Frames<dim>::surfaces(const double time) const
  {
    return scene.balance.surfaces(time,
                                  scene.grid.lower_corner(),
                                  scene.grid.upper_corner());
  }

  template <int dim>
  void
  Frames<dim>::write_surfaces(const double time)
  {
    const auto shown = is_first ? surfaces(time) : std::vector<Surface<dim>>();
    if (!dealii::Utilities::MPI::broadcast(communicator, !shown.empty()))
      return;
    DataFile<dim - 1, dim> file(std::vector<FieldDescription>{
      {"surface", 1, "1", "number of the tool, in the order of their names"}});
    for (unsigned int i = 0; i < shown.size(); ++i)
      for (const auto &facet : shown[i].facets)
        {
          // a triangle is a quadrilateral with one side of no length
          std::array<dealii::Point<dim>, 1u << (dim - 1)> vertices;
          std::array<double, 1u << (dim - 1)>             values;
          for (unsigned int v = 0; v < vertices.size(); ++v)
            {
              vertices[v] = facet[std::min<unsigned int>(v, dim - 1)];
              values[v]   = i;
            }
          file.add_cell(vertices,
                        dealii::ArrayView<const double>(values.data(),
                                                        values.size()));
        }
    surface_series.add(time,
                       file.write(directory.path(),
                                  "surfaces",
                                  state.n_frames,
                                  time,
                                  communicator));
  }

  template <int dim>
  typename Frames<dim>::Drawn
  Frames<dim>::gather_drawn(const std::size_t most) const
  {
    const std::size_t stride = 1 + scene.particles.n_global_particles() / most;
    Drawn             drawn;
    for (const auto &particle : scene.particles)
      if (particle.get_id() % stride == 0)
        {
          drawn.positions.push_back(particle.get_location());
          drawn.values.push_back(scene.drawn_number.value(particle));
        }
    const auto positions =
      dealii::Utilities::MPI::gather(communicator, drawn.positions);
    const auto values =
      dealii::Utilities::MPI::gather(communicator, drawn.values);
    for (unsigned int rank = 1; rank < positions.size(); ++rank)
      {
        drawn.positions.insert(drawn.positions.end(),
                               positions[rank].begin(),
                               positions[rank].end());
        drawn.values.insert(drawn.values.end(),
                            values[rank].begin(),
                            values[rank].end());
      }
    return drawn;
  }

  template <int dim>
  void
  Frames<dim>::take_picture(const double time)
  {
    state.last_picture = time;
    const Drawn drawn  = gather_drawn(max_drawn_particles);
    if (!is_first)
      return;
    pictures->add_snapshot<dim>(time,
                                drawn.positions,
                                drawn.values,
                                scene.grid.lower_corner(),
                                scene.grid.upper_corner(),
                                scene.grid.n_cells());
    pictures->add_surfaces(surfaces(time));
    state.pictures = pictures->memory();
  }

  template class Frames<2>;
  template class Frames<3>;
} // namespace emmy
