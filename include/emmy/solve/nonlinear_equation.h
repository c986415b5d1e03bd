#ifndef emmy_solve_nonlinear_equation_h
#define emmy_solve_nonlinear_equation_h

#include <emmy/system/node_places.h>

#include <string>

namespace emmy
{
  /** r(u) = 0, as Newton sees it: neither particles nor materials. */
  class NonlinearEquation
  {
  public:
    virtual ~NonlinearEquation() = default;

    /**
     * Evaluate residual() and, if asked for, jacobian() at @p solution.
     * Collective.
     * @return false on all ranks if the equation has no meaning there;
     *   problem() says why.
     */
    virtual bool
    evaluate(const Vector &solution, const bool with_jacobian) = 0;

    /**
     * r on free unknowns, with what their followers hand over to them; zero on
     * constrained ones.
     */
    virtual const Vector &
    residual() const = 0;

    /**
     * What an increment is found from: residual(), with the share of unknowns
     * that the equation eliminates by itself.
     */
    virtual const Vector &
    reduced_residual() const
    {
      return residual();
    }

    /** The derivative of r; Newton may add to it before it solves. */
    virtual Matrix &
    jacobian() = 0;

    /** Where the nodes of the unknowns are now; null: that is not known. */
    virtual const NodePlaces *
    node_places() const
    {
      return nullptr;
    }

    /** Give followers in an increment the values of their roots. Collective. */
    virtual void
    expand(Vector &increment) const = 0;

    /** The size of the forces that balance in r, in the 2-norm. */
    virtual double
    scale() const = 0;

    /** The size of the works of these forces: sum |F||u| over all of them. */
    virtual double
    work_scale() const = 0;

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
