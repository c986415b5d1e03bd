#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/run/saved_run.h>
#include <emmy/transfer/particle_parcel.h>

#include <boost/archive/binary_iarchive.hpp>
#include <boost/archive/binary_oarchive.hpp>
#include <boost/serialization/array.hpp>
#include <boost/serialization/string.hpp>
#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

#include <array>
#include <cstdint>
#include <cstring>
#include <sstream>

// How the parts of RunState are kept. Each is taken apart by name, so that a
// member that is added and not kept is an error of the compiler. A change of
// what is kept is a new CheckpointFolder::format.
namespace boost
{
  namespace serialization
  {
    template <class Archive>
    void
    serialize(Archive &archive, emmy::DetectorState &state, unsigned int)
    {
      auto &[kinetic, stored, largest, overfill, both, hidden, overfilled] =
        state;
      archive &kinetic &stored &largest &overfill &both &hidden &overfilled;
    }

    template <class Archive>
    void
    serialize(Archive &archive, emmy::EnergyEntry &entry, unsigned int)
    {
      auto &[name, kind, change] = entry;
      archive &name &kind &change;
    }

    template <class Archive>
    void
    serialize(Archive &archive, emmy::LedgerSums &sums, unsigned int)
    {
      auto &[energies, residual_work, balance_error] = sums;
      archive &energies &residual_work &balance_error;
    }

    template <class Archive>
    void
    serialize(Archive &archive, emmy::FilmFrame &frame, unsigned int)
    {
      auto &[time, points, lines] = frame;
      archive &time &points &lines;
    }

    template <class Archive>
    void
    serialize(Archive &archive, emmy::FramesState &state, unsigned int)
    {
      auto &[intervals,
             frames,
             n_pictures,
             frame,
             picture,
             reached,
             files,
             grids,
             surfaces,
             pictures,
             film_label,
             film] = state;
      archive &intervals &frames &n_pictures &frame &picture &reached;
      archive &files &grids &surfaces &pictures &film_label  &film;
    }

    template <class Archive>
    void
    serialize(Archive &archive, emmy::Told &told, unsigned int)
    {
      auto &[travel, struggled, places, detected, crossed, domains] = told;
      archive &travel &struggled &places &detected &crossed &domains;
    }

    template <class Archive>
    void
    serialize(Archive &archive, emmy::Struggles &struggles, unsigned int)
    {
      auto &[halvings, damped] = struggles;
      archive &halvings &damped;
    }

    template <class Archive>
    void
    serialize(Archive &archive, emmy::LinearSolverState &state, unsigned int)
    {
      auto &[first_size, n_direct_left, n_failures] = state;
      archive &first_size &n_direct_left &n_failures;
    }
  } // namespace serialization
} // namespace boost

namespace emmy
{
  namespace
  {
    template <class Write>
    std::string
    packed(const Write &write)
    {
      std::ostringstream out;
      {
        boost::archive::binary_oarchive archive(out);
        write(archive);
      }
      return out.str();
    }

    template <class Read>
    void
    unpack(const std::string &text, const Read &read)
    {
      std::istringstream              in(text);
      boost::archive::binary_iarchive archive(in);
      read(archive);
    }

    /** The same for both directions. */
    template <class Archive>
    void
    keep_head(Archive &archive, SavedRun &saved)
    {
      archive &saved.version &saved.parameters &saved.dimension &saved.step;
      archive &saved.time &saved.n_ranks &saved.is_failure &saved.fields;
      archive                                              &saved.state;
    }

    /** RunState without particles, and what measurements remember. */
    template <class Archive, int dim>
    void
    keep_state(Archive                                 &archive,
               RunState<dim>                           &run,
               std::vector<std::vector<std::uint64_t>> &measurements)
    {
      auto &[particles,
             step,
             time,
             kinetic_energy,
             detector,
             ledger,
             frames,
             frames_before_end,
             told,
             struggles,
             linear_solver,
             increment,
             occupancy] = run;
      (void)particles; // in the parts
      archive &step &time &kinetic_energy;
      archive &detector &ledger &frames &frames_before_end &told &struggles
                                    &linear_solver;
      archive &increment &occupancy &measurements;
    }

    /** Of one rank. */
    template <int dim>
    struct Part
    {
      std::vector<typename BackgroundGrid<dim>::Occupied> covered;
      std::vector<std::vector<double>>                    effects;
      std::vector<double> particles; ///< see Parcel

      /** All but the particles, which are many, and are not copied. */
      std::string
      rest() const
      {
        std::vector<std::uint32_t> cells;
        for (const auto &[place, n] : covered)
          {
            cells.insert(cells.end(), place.begin(), place.end());
            cells.push_back(n);
          }
        return packed([&](auto &archive) { archive << cells << effects; });
      }

      static Part
      of(const std::string &text, const bool with_particles)
      {
        std::uint64_t length = 0;
        std::memcpy(&length, text.data(), sizeof(length));
        Part                       part;
        std::vector<std::uint32_t> cells;
        emmy::unpack(text.substr(sizeof(length), length),
                     [&](auto &archive) { archive >> cells >> part.effects; });
        for (std::size_t i = 0; i < cells.size(); i += dim + 1)
          {
            CellKey<dim> place;
            std::copy_n(cells.begin() + i, dim, place.begin());
            part.covered.emplace_back(place, cells[i + dim]);
          }
        if (!with_particles)
          return part;
        const std::size_t begin = sizeof(length) + length;
        part.particles.resize((text.size() - begin) / sizeof(double));
        std::memcpy(part.particles.data(),
                    text.data() + begin,
                    part.particles.size() * sizeof(double));
        return part;
      }
    };

    std::vector<std::pair<std::string, unsigned int>>
    fields_of(const FieldLayout &layout)
    {
      std::vector<std::pair<std::string, unsigned int>> result;
      for (const Field &field : layout.fields())
        result.emplace_back(field.name, field.n_components);
      return result;
    }

    std::string_view
    bytes_of(const std::vector<double> &numbers)
    {
      return {reinterpret_cast<const char *>(numbers.data()),
              numbers.size() * sizeof(double)};
    }
  } // namespace

  SavedRun
  read_saved_run(const std::string &directory,
                 const MPI_Comm     communicator,
                 const std::string &for_what,
                 const unsigned int latest)
  {
    const CheckpointFolder   folder(directory, communicator);
    std::vector<std::string> problems;
    for (unsigned int before = latest;;)
      {
        ReadCheckpoint found = folder.read_newest(before);
        problems.insert(problems.end(),
                        found.passed_over.begin(),
                        found.passed_over.end());
        if (found.path.empty())
          break;
        SavedRun    saved;
        std::string problem;
        try
          {
            unpack(found.head,
                   [&](auto &archive) { keep_head(archive, saved); });
            if (saved.version != EMMY_VERSION)
              problem = "was written by emmy " + saved.version +
                        ", and this is emmy " EMMY_VERSION;
          }
        catch (const boost::archive::archive_exception &error)
          {
            problem = std::string("cannot be read: ") + error.what();
          }
        if (problem.empty())
          {
            saved.directory   = directory;
            saved.path        = found.path;
            saved.parts       = std::move(found.parts);
            saved.passed_over = problems;
            return saved;
          }
        problems.push_back("the checkpoint <" + found.path + "> " + problem);
        if (found.step == 0)
          break;
        before = found.step - 1;
      }
    AssertThrow(!problems.empty(),
                ExcRun(for_what,
                       "there is no checkpoint in <" + directory +
                         "/checkpoints>",
                       "name the results of a run that wrote some: its "
                       "section Checkpoint had Every steps or Every minutes, "
                       "or it was stopped by a signal."));
    AssertThrow(false,
                ExcRun(for_what,
                       "no checkpoint in <" + directory + "> can be used:\n  " +
                         join(problems, "\n  "),
                       "use the emmy that wrote them; if they are damaged, "
                       "run the scene anew."));
    return {};
  }

  template <int dim>
  std::string
  save(const Scene<dim>       &scene,
       const std::string      &parameters,
       const CheckpointFolder &folder,
       const unsigned int      n_kept,
       const bool              is_failure)
  {
    using namespace dealii::Utilities::MPI;
    Parcel<dim> parcel(scene.layout.n_components());
    parcel.values.reserve(scene.particles.n_locally_owned_particles() *
                          parcel.n_numbers());
    auto         cell = scene.grid.triangulation().end();
    CellKey<dim> place{};
    for (const auto &particle : scene.particles)
      {
        // those of a cell stand together
        if (particle.get_surrounding_cell() != cell)
          {
            cell  = particle.get_surrounding_cell();
            place = scene.grid.key_of(cell);
          }
        parcel.add(place, particle);
      }
    Part<dim> part;
    part.covered               = scene.grid.covered();
    part.effects               = scene.balance.memory();
    const std::string   rest   = part.rest();
    const std::uint64_t length = rest.size();

    SavedRun saved;
    saved.version    = EMMY_VERSION;
    saved.parameters = parameters;
    saved.dimension  = dim;
    saved.step       = scene.state.step;
    saved.time       = scene.state.time;
    saved.n_ranks    = n_mpi_processes(scene.grid.communicator());
    saved.is_failure = is_failure;
    saved.fields     = fields_of(scene.layout);
    std::vector<std::vector<std::uint64_t>> measurements;
    for (const auto &measurement : scene.measurements)
      {
        const auto memory = measurement->memory();
        measurements.emplace_back(memory.begin(), memory.end());
      }
    // archives read and write with the same words; nothing changes here
    auto &state = const_cast<RunState<dim> &>(scene.state);
    saved.state =
      packed([&](auto &archive) { keep_state(archive, state, measurements); });
    return folder.write(
      saved.step,
      packed([&](auto &archive) { keep_head(archive, saved); }),
      {{reinterpret_cast<const char *>(&length), sizeof(length)},
       rest,
       bytes_of(parcel.values)},
      n_kept);
  }

  template <int dim>
  void
  recall(const SavedRun &saved, Scene<dim> &scene)
  {
    AssertThrow(saved.fields == fields_of(scene.layout),
                ExcRun("Restart",
                       "the particles of <" + saved.path +
                         "> have other fields than this scene",
                       "restart with the effects, materials and method of "
                       "the run, or let a new run start from it (section "
                       "Start)."));
    std::vector<std::vector<std::uint64_t>> measurements;
    unpack(saved.state, [&](auto &archive) {
      keep_state(archive, scene.state, measurements);
    });
    for (unsigned int i = 0; i < scene.measurements.size(); ++i)
      scene.measurements[i]->recall(
        {measurements[i].begin(), measurements[i].end()});

    std::vector<typename BackgroundGrid<dim>::Occupied> covered;
    std::vector<std::vector<std::vector<double>>>       effects;
    for (const std::string &text : saved.parts)
      {
        const auto part = Part<dim>::of(text, /*with_particles=*/false);
        covered.insert(covered.end(), part.covered.begin(), part.covered.end());
        effects.push_back(part.effects);
      }
    const Parcel<dim> parcel = particles_of<dim>(saved);
    // that of rank 0 is on rank 0 again
    effects.insert(effects.begin(),
                   dealii::Utilities::MPI::broadcast(
                     scene.grid.communicator(),
                     effects.empty() ? std::vector<std::vector<double>>()
                                     : effects[0]));
    scene.balance.recall(effects);
    open_window(covered, scene.grid, scene.particles);
    scene.particles.reserve(parcel.n_particles());
    const std::uint64_t n_saved =
      dealii::Utilities::MPI::sum(std::uint64_t(parcel.n_particles()),
                                  scene.grid.communicator());
    deliver(parcel, scene.grid, scene.particles);
    throw_together(scene.grid.communicator(),
                   "Restart",
                   scene.particles.n_global_particles() == n_saved
                     ? ""
                     : "of " + std::to_string(n_saved) + " particles only " +
                         std::to_string(scene.particles.n_global_particles()) +
                         " found a cell",
                   "this should not happen; please report it with the "
                   "parameter file.");
  }

  template <int dim>
  Parcel<dim>
  particles_of(const SavedRun &saved)
  {
    unsigned int n_components = 0;
    for (const auto &[name, n] : saved.fields)
      n_components += n;
    Parcel<dim> parcel(n_components);
    for (const std::string &text : saved.parts)
      {
        auto part = Part<dim>::of(text, /*with_particles=*/true);
        if (parcel.values.empty())
          parcel.values = std::move(part.particles);
        else
          parcel.values.insert(parcel.values.end(),
                               part.particles.begin(),
                               part.particles.end());
      }
    return parcel;
  }

  template <int dim>
  std::map<std::string, double>
  stored_energies(const SavedRun &saved)
  {
    RunState<dim>                           state;
    std::vector<std::vector<std::uint64_t>> measurements;
    unpack(saved.state,
           [&](auto &archive) { keep_state(archive, state, measurements); });
    std::map<std::string, double> result;
    for (const EnergyEntry &entry : state.ledger.energies)
      if (entry.kind == EnergyEntry::Kind::stored)
        result[entry.name] = entry.change;
    return result;
  }

  template std::string
  save<2>(const Scene<2> &,
          const std::string &,
          const CheckpointFolder &,
          const unsigned int,
          const bool);
  template std::string
  save<3>(const Scene<3> &,
          const std::string &,
          const CheckpointFolder &,
          const unsigned int,
          const bool);
  template void
  recall<2>(const SavedRun &, Scene<2> &);
  template void
  recall<3>(const SavedRun &, Scene<3> &);
  template Parcel<2>
  particles_of<2>(const SavedRun &);
  template std::map<std::string, double>
  stored_energies<2>(const SavedRun &);
  template Parcel<3>
  particles_of<3>(const SavedRun &);
  template std::map<std::string, double>
  stored_energies<3>(const SavedRun &);
} // namespace emmy
