#ifndef emmy_solve_preconditioner_h
#define emmy_solve_preconditioner_h

#include <emmy/system/node_places.h>

#include <memory>
#include <string>

namespace emmy
{
  /** An approximate inverse of a matrix, for Krylov methods. */
  class Preconditioner
  {
  public:
    virtual ~Preconditioner() = default;

    /**
     * Make it for a matrix, which must stay alive unless outlives_matrix().
     * Collective.
     * @param places of the rows, for a coarse level; null: there is none
     */
    virtual void
    make(const Matrix &matrix, const NodePlaces *places) = 0;

    /** Whether it needs no more of its matrix, and serves for others of the
     * same nodes. */
    virtual bool
    outlives_matrix() const
    {
      return false;
    }

    /** z = P r. Collective. */
    virtual void
    vmult(Vector &z, const Vector &r) const = 0;
  };

  /**
   * @param name         a value of Solver/Preconditioner
   * @param n_components unknowns per node
   */
  std::unique_ptr<Preconditioner>
  make_preconditioner(const std::string &name, const unsigned int n_components);
} // namespace emmy

#endif
