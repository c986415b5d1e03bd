#ifndef emmy_base_linear_algebra_h
#define emmy_base_linear_algebra_h

#include <deal.II/lac/trilinos_sparse_matrix.h>
#include <deal.II/lac/trilinos_vector.h>

namespace emmy
{
  /** Distributed matrices and vectors of the grid's unknowns. */
  using Matrix = dealii::TrilinosWrappers::SparseMatrix;
  /** One number per unknown, distributed. */
  using Vector = dealii::TrilinosWrappers::MPI::Vector;
} // namespace emmy

#endif
