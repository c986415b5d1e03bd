#ifndef emmy_base_exceptions_h
#define emmy_base_exceptions_h

#include <deal.II/base/exceptions.h>
#include <deal.II/base/mpi.h>

#include <string>

namespace emmy
{
  /**
   * A parameter that cannot be used. Says where (section and entry), what
   * (the value) and how to mend it. Arguments: section path, entry, value as
   * text, what is required and what to do.
   */
  DeclException4(ExcParameter,
                 std::string,
                 std::string,
                 std::string,
                 std::string,
                 << "Parameter <" << arg1 << (arg1.empty() ? "" : "/") << arg2
                 << "> is <" << arg3 << ">: " << arg4);

  /**
   * Something that went wrong while a scene was built or run. Arguments:
   * where, what, how to fix it.
   */
  DeclException3(ExcRun,
                 std::string,
                 std::string,
                 std::string,
                 << arg1 << ": " << arg2 << "\n  Remedy: " << arg3);

  /** What an error says, without the frame that what() puts around it. */
  std::string
  message_of(const dealii::ExceptionBase &error);

  /**
   * The problem of the lowest rank that has one; empty if none has.
   * Collective.
   */
  std::string
  agree_on_problem(const MPI_Comm communicator, const std::string &problem);

  /**
   * Let all ranks stop together. Collective. Each rank passes an empty
   * string, or what went wrong on it. If any rank reports something, every
   * rank throws ExcRun with the message of the lowest such rank.
   *
   * @param where   what the program was doing, e.g. "Step 12"
   * @param problem what this rank found, empty if nothing
   * @param remedy  how to fix it
   */
  void
  throw_together(const MPI_Comm     communicator,
                 const std::string &where,
                 const std::string &problem,
                 const std::string &remedy);
} // namespace emmy

#endif
