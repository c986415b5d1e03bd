#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/solve/linear_solver.h>

namespace emmy
{
  const std::vector<Choice> &
  linear_solvers()
  {
    static const std::vector<Choice> choices{
      {"automatic",
       "direct for small systems; else GMRES, and direct where that fails"},
      {"direct", "LU factorisation"},
      {"GMRES", "Krylov method with <Preconditioner>, for any matrix"},
      {"BiCGStab", "Krylov method with <Preconditioner>, needs less memory"}};
    return choices;
  }

  const std::vector<Choice> &
  preconditioners()
  {
    static const std::vector<Choice> choices{
      {"Jacobi", "the diagonal: cheap and weak"},
      {"ILU",
       "incomplete factorisation on each rank, with a coarse level of boxes"},
      {"ML", "algebraic multigrid, for large systems"}};
    return choices;
  }

  namespace
  {
    /** The names of choices, as a pattern. */
    dealii::Patterns::Selection
    selection(const std::vector<Choice> &choices)
    {
      std::vector<std::string> names;
      for (const Choice &choice : choices)
        names.push_back(choice.name);
      return dealii::Patterns::Selection(join(names, "|"));
    }
  } // namespace

  SolverParameters::SolverParameters(const std::string &path)
    : Section(path)
  {
    add_parameter("Linear solver",
                  linear_solver,
                  "direct: LU factorisation. GMRES, BiCGStab: Krylov methods "
                  "with <Preconditioner>. automatic: direct for small systems; "
                  "else GMRES, and direct where that fails.",
                  prm,
                  selection(linear_solvers()));
    add_parameter("Preconditioner",
                  preconditioner,
                  "Of the Krylov methods. ML is algebraic multigrid.",
                  prm,
                  selection(preconditioners()));
    add_parameter("Linear tolerance",
                  linear_tolerance,
                  "Residual of the first Krylov solve of a step, relative to "
                  "its right-hand side; later ones are as much tighter as "
                  "Newton falls. Dimensionless, between 0 and 1.",
                  prm,
                  dealii::Patterns::Double(0., 1.));
    add_parameter("Newton tolerance",
                  newton_tolerance,
                  "Newton stops when sum |r||du| has fallen to this fraction "
                  "of its first value (Pretti et al. 2023, sec. 3.4), or the "
                  "residual to round-off. Dimensionless, between 0 and 1.",
                  prm,
                  dealii::Patterns::Double(0., 1.));
    add_parameter("Maximum iterations",
                  maximum_iterations,
                  "Newton iterations after which a try is given up: the "
                  "plain one, then one with a damped matrix, then the step is "
                  "halved. Few steps need more than 5; a particle alone among "
                  "new nodes may need many, and then half the step does not "
                  "help.",
                  prm,
                  dealii::Patterns::Integer(1));
  }

  void
  SolverParameters::validate() const
  {
    const auto require_fraction = [this](const std::string &name,
                                         const double       value) {
      AssertThrow(value > 0. && value < 1.,
                  ExcParameter(path(),
                               name,
                               shortest(value),
                               "must lie between 0 and 1, both excluded."));
    };
    require_fraction("Linear tolerance", linear_tolerance);
    require_fraction("Newton tolerance", newton_tolerance);
  }
} // namespace emmy
