#ifndef emmy_system_constraints_h
#define emmy_system_constraints_h

#include <deal.II/base/partitioner.h>

#include <deal.II/lac/affine_constraints.h>

#include <emmy/base/linear_algebra.h>

#include <memory>
#include <utility>
#include <vector>

namespace emmy
{
  /**
   * Linear conditions on the unknowns of an active grid: fixed ones, whose
   * values others give, and followers, u = sum of weights times the unknowns
   * of its roots. A root may be fixed, but is no follower. With C the matrix
   * that makes all unknowns from the free ones, equations become
   * @f$ C^T A C x = C^T b @f$.
   *
   * Owned by ActiveGrid. A default one has no condition.
   */
  class Constraints
  {
  public:
    using Dof = dealii::types::global_dof_index; ///< an unknown
    /** Unknowns and weights. */
    using Entries = std::vector<std::pair<Dof, double>>;

    Constraints();

    /** None yet, on these unknowns. Each rank states all that it knows. */
    explicit Constraints(
      std::shared_ptr<const dealii::Utilities::MPI::Partitioner> partition);

    /** It stays zero. */
    void
    fix(const Dof dof);

    /** @param entries roots, known to this rank, and their weights */
    void
    follow(const Dof dof, const Entries &entries);

    /**
     * To be called once, after the last condition.
     * @param has_followers whether any rank has a follower
     */
    void
    close(const bool has_followers);

    /** With fixed unknowns at zero: what assembly distributes with. */
    const dealii::AffineConstraints<double> &
    affine() const
    {
      return lines;
    }

    /** Whether there is any condition on this rank. */
    bool
    empty() const
    {
      return lines.n_constraints() == 0;
    }

    /** Whether any rank has a follower. */
    bool
    has_followers() const
    {
      return is_followed;
    }

    /** Set fixed unknowns and followers to zero. */
    void
    set_zero(Vector &vector) const
    {
      lines.set_zero(vector);
    }

    /** Give followers the values that their roots have. Collective. */
    void
    expand(Vector &values) const;

    /**
     * Hand the forces on followers over to their roots, fixed ones among them:
     * the work on values that expand() made stays. Collective.
     */
    void
    fold(Vector &forces) const;

    /** C^T times forces: fold(), then set_zero(). Collective. */
    void
    condense(Vector &forces) const;

  private:
    struct Follower
    {
      unsigned int                                 dof; ///< local index
      std::vector<std::pair<unsigned int, double>> roots;
    };

    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> partition;
    dealii::AffineConstraints<double>                          lines;
    std::vector<Follower> followers; ///< those that this rank owns
    bool                  is_followed = false;
  };
} // namespace emmy

#endif
