#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>

#include <sstream>

namespace emmy
{
  std::string
  message_of(const dealii::ExceptionBase &error)
  {
    std::ostringstream text;
    error.print_info(text);
    return dealii::Utilities::trim(text.str());
  }

  std::string
  agree_on_problem(const MPI_Comm communicator, const std::string &problem)
  {
    using namespace dealii::Utilities::MPI;
    const unsigned int nobody = n_mpi_processes(communicator);
    const unsigned int spokesman =
      min(problem.empty() ? nobody : this_mpi_process(communicator),
          communicator);
    return spokesman == nobody ? std::string()
                               : broadcast(communicator, problem, spokesman);
  }

  void
  throw_together(const MPI_Comm     communicator,
                 const std::string &where,
                 const std::string &problem,
                 const std::string &remedy)
  {
    const std::string agreed = agree_on_problem(communicator, problem);
    AssertThrow(agreed.empty(), ExcRun(where, agreed, remedy));
  }
} // namespace emmy
