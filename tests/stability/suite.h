#ifndef emmy_tests_stability_suite_h
#define emmy_tests_stability_suite_h

#include <emmy/run/scene.h>

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  namespace stability
  {
    /** How a run went. */
    struct Result
    {
      bool         has_ended = false;
      std::string  problem; ///< in words, if it has not
      unsigned int steps = 0, halvings = 0, damped = 0, most_iterations = 0;
      /** Largest condition of the scaled matrices; 0: not measured. */
      double mass_condition = 0., jacobian_condition = 0.;
      double energy       = 0.; ///< the largest kinetic + stored energy, J
      double final_energy = 0.; ///< kinetic + stored, J
      /** Of energy: ghost losses, and what no column accounts for. */
      double lost = 0., drift = 0.;
      /** Of energy, largest in size over the steps. */
      double balance_error = 0., residual_work = 0.;
      /** Largest change, of m v and m v times the extent of the bodies. */
      double linear_momentum = 0., angular_momentum = 0.;
      double seconds = 0.;
      /** Kinetic and strain energy of each step, of energy; times, s. */
      std::vector<double> kinetic, strain, times;
      /** Nodes that follow, of each step. */
      std::vector<double> followers;
      /** Of all particles, at the end, by their number, m. */
      std::vector<double> positions;
      /** Balance error of each step, relative to energy. */
      std::vector<double> balance_errors;
      /** The columns of the ledger. */
      std::map<std::string, std::vector<double>> ledger;
    };

    /** A file, what is set in it, and what is done to the scene before it runs.
     */
    template <int dim>
    struct Run
    {
      std::string                       file; ///< in prm/
      std::vector<std::string>          settings;
      std::function<void(Scene<dim> &)> prepare = {};
      /** Whether to measure the condition of the matrices in each step. */
      bool with_conditions = false;
      /**
       * Whether the ledger must balance to 1e-11; without a remedy numbers at
       * starved nodes can be so large that 1e-6 is all that round-off leaves.
       */
      bool is_stabilised = true;
    };

    /** Run a file of @p folder/prm to its end or an error. */
    template <int dim>
    Result
    run_scene(const std::string &folder, const Run<dim> &run);

    /** What is done against small cuts. */
    struct Remedy
    {
      std::string              name; ///< as rows call it: ", ghosts"; or empty
      std::vector<std::string> settings; ///< none: nothing is done
    };

    const Remedy nothing{"", {}};
    const Remedy ghosts{", ghosts", {"Effects/Names=ghost stabilisation"}};
    const Remedy small_ghosts{
      ", small ghost mass",
      {"Effects/Names=ghost stabilisation",
       "Effects/Ghost stabilisation/Mass penalty=1e-3",
       "Effects/Ghost stabilisation/Stiffness penalty=0"}};
    const Remedy followers{", followers", {"Method/Starved nodes=follow"}};

    using Point = std::pair<double, double>;

    enum class Panel
    {
      tip,     ///< condition of the mass matrix over the offset
      steps,   ///< balance error over the steps
      elastic, ///< energies of example 7.2 over time
      plastic  ///< of 7.3B
    };

    /**
     * What the cases run, state and write. Holds the page that is made of it,
     * doc/stability.md, and the curves of its picture.
     */
    class Suite
    {
    public:
      explicit Suite(const std::string &source_folder)
        : source_folder(source_folder)
      {}

      /** Begin the table of a case. */
      void
      open_case(const std::string &title, const std::string &text);

      /**
       * Run to the end, and add a row to the table. Whatever happens must be
       * told: a run that ends balances, one that stops says where and why.
       */
      template <int dim>
      Result
      run(const std::string &variant, const Run<dim> &run);

      /** The same, without a row. */
      template <int dim>
      Result
      measure(const std::string &variant, const Run<dim> &run);

      /** A row for several runs: the worst of each column. */
      void
      add_row(const std::string &variant, const std::vector<Result> &results);

      /** Run, and add one row for all. */
      template <int dim>
      std::vector<Result>
      run_all(const std::string &variant, const std::vector<Run<dim>> &runs);

      /** The last run must have reached its end, as its row says. */
      void
      must_end(const Result &result) const;
      /** State a bound of the last run, print what was measured, check it. */
      void
      at_most(const std::string &what, const double value, const double bound);
      void
      at_least(const std::string &what, const double value, const double bound);
      /** The same of a number that has a right value. */
      void
      is(const std::string &what,
         const double       value,
         const double       right,
         const double       tolerance);

      /** A curve in a panel of the pictures. */
      void
      curve(const Panel               panel,
            const std::string        &name,
            const std::vector<Point> &points);

      /** Write stability.md and its pictures to a folder. */
      void
      write(const std::string &folder);

    private:
      /** Put the bounds below the table. */
      void
      close_case();
      void
      bound(const std::string &what,
            const double       value,
            const double       limit,
            const bool         holds,
            const char        *relation);

      void
      draw(const std::string &folder, const std::string &picture) const;

      struct Curve
      {
        Panel              panel;
        std::string        name;
        std::vector<Point> points;
      };

      const std::string  source_folder;
      std::string        page, bounds; ///< bounds: of the case that is open
      std::string        last_variant, bound_variant; ///< the bounds' last
      std::vector<Curve> curves;
    };

    /** A case of the suite, by the name that ctest knows. */
    struct Case
    {
      std::string name;
      void (*run)(Suite &);
    };

    /**
     * Cases that begin with a small cut, those that compare the remedies
     * against it, and the others.
     */
    std::vector<Case>
    small_cuts();
    std::vector<Case>
    remedies();
    std::vector<Case>
    hard_motions();
    /** A plain scene in space. */
    std::vector<Case>
    cantilever_cases();
    /** Scenes of prm/field against their right values. */
    std::vector<Case>
    field_cases();

    // what all use
    const std::string gimp     = "Method/Shape functions=GIMP";
    const std::string at_start = "Method/Geometry=start";

    /** These settings and those. */
    inline std::vector<std::string>
    with(std::vector<std::string>        settings,
         const std::vector<std::string> &more)
    {
      settings.insert(settings.end(), more.begin(), more.end());
      return settings;
    }

    /**
     * Bounds of a run with a remedy: to the end, iterations, ghost losses,
     * which without ghosts are none.
     */
    void
    check_stable(Suite             &suite,
                 const Remedy      &remedy,
                 const Result      &result,
                 const unsigned int most_iterations,
                 const double       most_lost);
  } // namespace stability
} // namespace emmy

#endif
