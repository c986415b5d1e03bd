#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/base/whole_file.h>
#include <emmy/run/failure_bundle.h>
#include <emmy/run/saved_run.h>
#include <emmy/transfer/particle_sort.h>

#include <filesystem>
#include <sstream>
#include <system_error>

namespace emmy
{
  namespace
  {
    namespace fs = std::filesystem;

    /** cause.txt */
    std::string
    text_of(const FailureRecord &failure,
            const std::string   &cause,
            const std::string   &folder)
    {
      std::ostringstream out;
      out << cause << "\n\n"
          << "Repeat this step, with other settings if you like:\n"
             "  emmy --restart "
          << folder << " --set \"Section/Name=value\"\n";
      if (!failure.weakest.empty())
        out << "\nWhere the matrix is weakest\n  " << failure.weakest << '\n';
      if (!failure.tries.empty())
        out
          << "\nTries: the size of the step, why it failed, and |r| (N) before "
             "the first and after each iteration of Newton that was kept\n";
      for (const FailedTry &one : failure.tries)
        {
          out << "  " << brief(one.time_step) << " s: " << one.problem
              << "\n   ";
          for (const double residual : one.residuals)
            out << ' ' << brief(residual);
          out << '\n';
        }
      return out.str();
    }

    /** The files of rank 0. What went wrong, or nothing. */
    std::string
    write_files(const RunDirectory &directory,
                const std::string  &folder,
                const std::string  &parameters,
                const std::string  &cause)
    {
      const auto in = [&folder](const char *name) {
        return (fs::path(folder) / name).string();
      };
      std::error_code error;
      fs::copy_file(directory.file("ledger.csv"),
                    in("ledger.csv"),
                    fs::copy_options::overwrite_existing,
                    error);
      std::string problem =
        error ? cannot_write(in("ledger.csv"), error.value()) : std::string();
      if (problem.empty())
        problem = write_whole_file(in("parameters.prm"), parameters);
      if (problem.empty())
        problem = write_whole_file(in("cause.txt"), cause);
      return problem;
    }
  } // namespace

  template <int dim>
  std::string
  write_failure_bundle(Scene<dim>         &scene,
                       const std::string  &parameters,
                       const RunDirectory &directory,
                       const std::string  &cause)
  {
    const MPI_Comm communicator = scene.grid.communicator();
    // a step may have handed particles to the cells of its middle
    sort_into_cells(scene.grid, scene.particles);
    const std::string folder = directory.file("failure");
    std::string       problem;
    if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
      {
        std::error_code error;
        fs::create_directories(folder, error);
        problem = error ? cannot_write(folder, error.value())
                        : write_files(directory,
                                      folder,
                                      parameters,
                                      text_of(scene.stepper->last_failure(),
                                              cause,
                                              folder));
      }
    problem = agree_on_problem(communicator, problem);
    return problem.empty() ? save(scene,
                                  parameters,
                                  CheckpointFolder(folder, communicator),
                                  /*n_kept=*/1,
                                  /*is_failure=*/true)
                           : problem;
  }

  template std::string
  write_failure_bundle<2>(Scene<2> &,
                          const std::string &,
                          const RunDirectory &,
                          const std::string &);
  template std::string
  write_failure_bundle<3>(Scene<3> &,
                          const std::string &,
                          const RunDirectory &,
                          const std::string &);
} // namespace emmy
