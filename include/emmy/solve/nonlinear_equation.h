#ifndef emmy_solve_nonlinear_equation_h
#define emmy_solve_nonlinear_equation_h

#include <emmy/system/node_places.h>
#include <emmy/system/rank_one.h>

#include <string>
#include <vector>

namespace emmy
{
  /** What an evaluation of an equation r(u) = 0 leaves for Newton; borrowed. */
  struct NewtonSystem
  {
    /**
     * r on free unknowns, with what their followers hand over to them; zero on
     * constrained ones.
     */
    const Vector &residual;
    /**
     * What an increment is found from: the residual, with the share of unknowns
     * that the equation eliminates by itself.
     */
    const Vector &reduced_residual;
    Matrix       &jacobian; ///< dr/du; Newton may add to it
    /** What dr/du has besides. */
    const std::vector<RankOne> &rank_ones;
    double scale      = 0.; ///< size of the forces that balance in r, N
    double work_scale = 0.; ///< of their works, sum |F||u|, J
    /** Where the nodes of the unknowns are now; null: that is not known. */
    const NodePlaces *node_places = nullptr;
  };

  /** r(u) = 0, as Newton sees it: neither particles nor materials. */
  class NonlinearEquation
  {
  public:
    virtual ~NonlinearEquation() = default;

    /**
     * Evaluate the system at @p solution, its jacobian only if asked for.
     * Collective.
     * @return false on all ranks if the equation has no meaning there;
     *   problem() says why.
     */
    virtual bool
    evaluate(const Vector &solution, const bool with_jacobian) = 0;

    /** That of the last evaluation. */
    virtual NewtonSystem
    system() = 0;

    /** Give followers in an increment the values of their roots. Collective. */
    virtual void
    expand(Vector &increment) const = 0;

    /**
     * How far an increment of the solution goes, dimensionless: where it is
     * above one, a linearisation is worth nothing. Collective.
     */
    virtual double
    size(const Vector &increment) const = 0;

    /**
     * Whether forces have kinks in the solution, as where something touches:
     * an increment is then worth no more than it lowers the residual.
     */
    virtual bool
    has_kinks() const
    {
      return false;
    }

    /**
     * Take an increment: add it to the solution and let follow what depends on
     * it. The equation may number its unknowns anew; then both vectors are.
     * Collective.
     */
    virtual void
    take(Vector &solution, Vector &increment)
    {
      solution += increment;
    }

    /** Halve the increment that was taken last. Collective. */
    virtual void
    halve(Vector &solution, Vector &increment)
    {
      increment *= 0.5;
      solution -= increment;
    }

    /** Undo the last take(). Collective. */
    virtual void
    take_back(Vector &solution, Vector &increment)
    {
      solution -= increment;
    }

    /**
     * Whether what the equation eliminates by itself holds well enough at the
     * last evaluation to end there.
     */
    virtual bool
    is_settled() const
    {
      return true;
    }

    /**
     * Begin again from where the first solution was, for a second try; what
     * moves with the solution stays there from now on. Collective.
     */
    virtual void
    begin_again(Vector &solution, const Vector &first)
    {
      solution = first;
    }

    /** What was wrong in the last evaluation, on all ranks; or empty. */
    virtual const std::string &
    problem() const = 0;
  };
  /** sum |a_i||b_i| over all unknowns. Collective. */
  double
  absolute_product(const Vector &a, const Vector &b);
} // namespace emmy

#endif
