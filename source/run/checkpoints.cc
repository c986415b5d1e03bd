#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/run/checkpoints.h>

#include <sstream>

namespace emmy
{
  template <int dim>
  std::string
  text_of(const SceneParameters<dim> &parameters)
  {
    std::ostringstream text;
    parameters.print(text);
    return text.str();
  }

  template <int dim>
  Checkpoints<dim>::Checkpoints(Scene<dim>                 &scene,
                                const SceneParameters<dim> &parameters,
                                const Ledger               &ledger,
                                const std::string          &directory,
                                const SignalWatch          *signals)
    : scene(scene)
    , wanted(parameters.checkpoint)
    , parameters(text_of(parameters))
    , ledger(ledger)
    , directory(directory)
    , folder(directory, scene.grid.communicator())
    , signals(signals)
    , last_time(std::chrono::steady_clock::now())
    , last_step(scene.state.step)
  {}

  template <int dim>
  std::string
  Checkpoints<dim>::after_step()
  {
    using namespace dealii::Utilities::MPI;
    // a signal may come to one rank alone, and clocks differ
    const MPI_Comm communicator = scene.grid.communicator();
    const double   minutes      = std::chrono::duration<double, std::ratio<60>>(
                             std::chrono::steady_clock::now() - last_time)
                             .count();
    const bool is_late = this_mpi_process(communicator) == 0 &&
                         wanted.every_minutes > 0. &&
                         minutes >= wanted.every_minutes;
    const std::vector<int> here{signals ? signals->received() : 0, is_late};
    std::vector<int>       all(2);
    max(here, communicator, all);
    signal = all[0];
    const bool is_due =
      wanted.every_steps > 0 && scene.state.step % wanted.every_steps == 0;
    return signal != 0 || all[1] != 0 || is_due ? write() : std::string();
  }

  template <int dim>
  std::string
  Checkpoints<dim>::at_end()
  {
    if (!wanted.is_on() || (is_written && last_step == scene.state.step))
      return {};
    return write();
  }

  template <int dim>
  std::string
  Checkpoints<dim>::write()
  {
    const auto timed = scene.phases.scope("checkpoint");
    // rows of the ledger must not be younger than the state
    const std::string problem =
      agree_on_problem(scene.grid.communicator(), ledger.flush());
    const std::string failed =
      problem.empty() ? save(scene, parameters, folder, wanted.keep) : problem;
    last_time = std::chrono::steady_clock::now();
    if (!failed.empty())
      return "the checkpoint of step " + std::to_string(scene.state.step) +
             " is not written: " + failed +
             (is_written
                ? ". That of step " + std::to_string(last_step) + " is kept"
                : std::string());
    is_written = true;
    last_step  = scene.state.step;
    return {};
  }

  template <int dim>
  std::string
  Checkpoints<dim>::farewell() const
  {
    return "interrupted by " + SignalWatch::name(signal) + " after step " +
           std::to_string(scene.state.step) +
           ", t = " + brief(scene.state.time) + " s. " +
           (is_written && last_step == scene.state.step
              ? "It goes on with: emmy --restart " + directory
            : is_written ? "It goes on from step " + std::to_string(last_step) +
                             " with: emmy --restart " + directory
                         : std::string("There is no checkpoint to go on from"));
  }

#define INSTANTIATE(dim)                                           \
  template std::string text_of<dim>(const SceneParameters<dim> &); \
  template class Checkpoints<dim>;
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
