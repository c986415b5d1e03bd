#ifndef emmy_tests_stability_suite_h
#define emmy_tests_stability_suite_h

#include <emmy/study/scene.h>

#include <functional>
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
      /** Strain energy of each step, of energy. */
      std::vector<double> strain;
      /** Balance error of each step, relative to energy. */
      std::vector<double> balance_errors;
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

    using Point = std::pair<double, double>;

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

      /** The same for several runs in one row: the worst of each column. */
      template <int dim>
      std::vector<Result>
      run_all(const std::string &variant, const std::vector<Run<dim>> &runs);

      /** State a bound of the last run, print what was measured, check it. */
      void
      at_most(const std::string &what, const double value, const double bound);
      void
      at_least(const std::string &what, const double value, const double bound);

      /** A curve of panel @p panel of the picture. */
      void
      curve(const unsigned int        panel,
            const std::string        &name,
            const std::vector<Point> &points);

      /** Write stability.md and pictures/stability.png to a folder. */
      void
      write(const std::string &folder);

    private:
      /** Put the bounds below the table. */
      void
      close_case();
      void
      add_row(const std::string &variant, const std::vector<Result> &results);
      void
      bound(const std::string &what,
            const double       value,
            const double       limit,
            const bool         holds,
            const char        *relation);

      struct Curve
      {
        unsigned int       panel;
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

    /** Cases that begin with a small cut, and the others. */
    std::vector<Case>
    small_cuts();
    std::vector<Case>
    hard_motions();

    // what both use
    const std::string ghosts = "Effects/Names=ghost stabilisation";
    const std::string gimp   = "Method/Shape functions=GIMP";

    /** The settings, and one more if it is there. */
    inline std::vector<std::string>
    with(std::vector<std::string> settings,
         const std::string       &setting,
         const bool               is_there)
    {
      if (is_there)
        settings.push_back(setting);
      return settings;
    }

    /** Bounds of a run with a remedy: to the end, iterations, losses. */
    void
    check_stable(Suite             &suite,
                 const Result      &result,
                 const unsigned int most_iterations,
                 const double       most_lost);
  } // namespace stability
} // namespace emmy

#endif
