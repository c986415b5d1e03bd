#include <deal.II/base/types.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/index_limits.h>
#include <emmy/base/text.h>

#include <cmath>
#include <limits>

namespace emmy
{
  namespace
  {
    /** What is wrong with so many of something; empty if nothing is. */
    std::string
    problem_of(const double       number,
               const std::string &of_what,
               const double       most)
    {
      return number <= most
               ? std::string()
               : brief(number) + " " + of_what + ": their numbers end at " +
                   dealii::Utilities::to_string(most);
    }

    void
    refuse(const std::string &where,
           const std::string &problem,
           const std::string &remedy)
    {
      AssertThrow(problem.empty(), ExcRun(where, problem, remedy));
    }

    constexpr double most_of_epetra = std::numeric_limits<int>::max();
  } // namespace

  void
  refuse_lattice(const std::vector<unsigned int> &n_cells)
  {
    double all = 1.;
    for (const unsigned int n : n_cells)
      all *= n;
    refuse("Grid",
           problem_of(all, "places for cells", std::ldexp(1., 63)),
           "take fewer Cells.");
  }

  void
  refuse_cells(const double n_cells, const double n_nodes)
  {
    // the largest number stands for none
    constexpr double most =
      std::numeric_limits<dealii::types::global_dof_index>::max() - 1.;
    std::string problem = problem_of(n_cells, "cells around the bodies", most);
    if (problem.empty())
      problem =
        problem_of(n_nodes, "nodes of the cells around the bodies", most);
    refuse("Grid", problem, "take larger cells, that is fewer Cells.");
  }

  void
  refuse_unknowns(const std::uint64_t n_unknowns)
  {
    refuse("Grid",
           problem_of(n_unknowns, "unknowns", most_of_epetra),
           "take larger cells, that is fewer Cells.");
  }

  void
  refuse_matrix_entries(const std::uint64_t n_entries,
                        const MPI_Comm      communicator)
  {
    throw_together(communicator,
                   "Matrix",
                   problem_of(n_entries,
                              "entries of a matrix on one rank",
                              most_of_epetra),
                   "start on more ranks, or take larger cells (Grid/Cells).");
  }
} // namespace emmy
