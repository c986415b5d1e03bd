#ifndef emmy_tests_scene_h
#define emmy_tests_scene_h

#include <emmy/output/ledger.h>
#include <emmy/run/scene.h>

#include <fstream>
#include <string>

#include "check.h"

namespace emmy
{
  namespace test
  {
    /**
     * A scene that runs in memory, with its ledger. The ledger's balance holds
     * for any displacement; only the work of what Newton left tells that the
     * equation of motion was solved. So it is bounded for each scene, at the
     * latest when the scene is gone.
     */
    template <int dim>
    struct RunningScene
    {
      Scene<dim>               scene;
      Ledger                   ledger;
      std::vector<std::string> notes; ///< for the screen, of all steps
      /** Work that the solves may leave in all steps, without signs, of the
       * largest energy; more where Newton is to stop early. A scene with nodes
       * of next to no mass sets its own. */
      double most_residual_work;

      RunningScene(const SceneParameters<dim> &parameters,
                   const MPI_Comm              communicator = MPI_COMM_WORLD)
        : scene(parameters, communicator)
        , ledger(scene.initial_report(), dim)
        , most_residual_work(
            std::max(1e-9, 0.01 * parameters.solver.newton_tolerance))
      {}

      ~RunningScene()
      {
        const double       left = residual_work();
        std::ostringstream text;
        text << "work of residuals " << left << " of the energy, at most "
             << most_residual_work;
        check(left <= most_residual_work, text.str());
      }

      RunningScene(const RunningScene &) = delete;

      /** That of all steps, without signs, over the largest energy. */
      double
      residual_work() const
      {
        const auto          work   = column("residual_work");
        std::vector<double> energy = column("kinetic_energy");
        for (const EnergyEntry &entry : ledger.energies())
          {
            const auto change = column(entry.name);
            for (unsigned int row = 0; row < energy.size(); ++row)
              energy[row] += std::abs(change[row]);
          }
        double sum = 0., scale = 0.;
        for (unsigned int row = 1; row < work.size(); ++row)
          sum += std::abs(work[row] - work[row - 1]);
        for (const double value : energy)
          scale = std::max(scale, value);
        return sum > 0. || std::isnan(sum) ? sum / scale : 0.;
      }

      void
      advance(const unsigned int n_steps)
      {
        for (unsigned int i = 0; i < n_steps; ++i)
          {
            const StepReport report = scene.advance();
            ledger.add(report);
            notes.insert(notes.end(), report.notes.begin(), report.notes.end());
          }
      }

      void
      advance_to(const double time)
      {
        while (ledger["time"] < time)
          advance(1);
      }

      /** A column over all rows. */
      std::vector<double>
      column(const std::string &name) const
      {
        const auto &names = ledger.columns();
        const auto  position =
          std::find(names.begin(), names.end(), name) - names.begin();
        std::vector<double> result;
        for (const auto &row : ledger.rows())
          result.push_back(row[position]);
        return result;
      }
    };

    /** Mass of all particles of all ranks, kg. */
    template <int dim>
    double
    total_mass(const Scene<dim> &scene)
    {
      double mass = 0.;
      for (const auto &particle : scene.particles)
        mass += particle.get_properties()[scene.layout["mass"]];
      return dealii::Utilities::MPI::sum(mass, MPI_COMM_WORLD);
    }

    /** How many of some notes are the detector's. */
    inline unsigned int
    n_warnings(const std::vector<std::string> &notes)
    {
      unsigned int n = 0;
      for (const std::string &note : notes)
        n += note.find("Results can be wrong while all balances hold") !=
             std::string::npos;
      return n;
    }

    /** The least change from one value to the next, or 0; NaN if there is one.
     */
    inline double
    least_change(const std::vector<double> &values)
    {
      double least = 0.;
      for (unsigned int i = 1; i < values.size(); ++i)
        if (!(values[i] - values[i - 1] >= least))
          least = values[i] - values[i - 1];
      return least;
    }

    /** The largest magnitude; NaN if there is one. */
    inline double
    largest(const std::vector<double> &values)
    {
      double result = 0.;
      for (const double value : values)
        if (!(std::abs(value) <= result)) // NaN too
          result = std::abs(value);
      return result;
    }

    /** Print a number that the scene is judged by, then judge it. */
    inline void
    at_most(const std::string &what, const double value, const double limit)
    {
      std::cout << std::left << std::setw(52) << what << std::setprecision(3)
                << value << "  (at most " << limit << ")\n";
      check(value <= limit, what);
    }

    /**
     * Columns of the ledger differ by at most 1e-10 of their largest value;
     * energies of the largest of them all.
     */
    template <int dim>
    void
    check_same_ledgers(const RunningScene<dim>        &one_rank,
                       const RunningScene<dim>        &all_ranks,
                       const std::vector<std::string> &columns)
    {
      check(all_ranks.ledger.rows().size() == one_rank.ledger.rows().size(),
            "as many steps as on one rank");
      for (const std::string &name : columns)
        {
          const auto a = one_rank.column(name), b = all_ranks.column(name);
          std::vector<double> difference;
          for (unsigned int row = 0; row < std::min(a.size(), b.size()); ++row)
            difference.push_back(a[row] - b[row]);
          double scale = largest(a);
          if (name.find("energy") != std::string::npos)
            scale = std::max(scale, largest(one_rank.column("kinetic_energy")));
          at_most(name + ", difference to one rank",
                  largest(difference) / scale,
                  1e-10);
        }
    }

    /** The first steps of a scene, on one rank and on all: the same ledger. */
    template <int dim>
    void
    compare_ranks(const ParameterFile            &file,
                  const unsigned int              n_steps,
                  const std::string              &name,
                  const std::vector<std::string> &columns)
    {
      if (dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
        std::cout << name << '\n';
      const SceneParameters<dim> parameters(file);
      RunningScene<dim>          one_rank(parameters, MPI_COMM_SELF);
      one_rank.advance(n_steps);
      RunningScene<dim> all_ranks(parameters, MPI_COMM_WORLD);
      all_ranks.advance(n_steps);
      check_same_ledgers(one_rank, all_ranks, columns);
    }

    /** Two discs of two materials that collide off their axis. */
    inline std::string
    collision_text(const unsigned int points_per_direction,
                   const std::string &shape_functions = "linear")
    {
      const std::string points = std::to_string(points_per_direction);
      return "set Dimension = 2\n"
             "subsection Method\nset Shape functions = " +
             shape_functions +
             "\nset Starved nodes = free\nend\n"
             "subsection Grid\n"
             "set Lower corner = 0, 0\n"
             "set Upper corner = 6, 4\n"
             "set Cells = 12, 8\n"
             "end\n"
             "subsection Materials\n"
             "set Names = rubber, cork\n"
             "subsection rubber\n"
             "set Model = Hencky\nset Density = 5\n"
             "set Young's modulus = 100\nset Poisson's ratio = 0.3\n"
             "end\n"
             "subsection cork\n"
             "set Model = Hencky\nset Density = 2\n"
             "set Bulk modulus = 40\nset Shear modulus = 60\n"
             "end\nend\n"
             "subsection Bodies\n"
             "set Names = left, right\n"
             "subsection left\n"
             "set Shape = ball\nset Material = rubber\n"
             "set Points per direction = " +
             points +
             "\nset Initial velocity = 0.9; 0.1\n"
             "subsection ball\n"
             "set Center = 1.9, 1.8\nset Radius = 0.8\nend\nend\n"
             "subsection right\n"
             "set Shape = ball\nset Material = cork\n"
             "set Points per direction = " +
             points +
             "\nset Initial velocity = -0.7; 0\n"
             "subsection ball\n"
             "set Center = 4, 2.3\nset Radius = 0.9\nend\nend\nend\n"
             "subsection Time\nset End time = 2\n"
             "set Step rule = normalised\nset Factor = 0.4\nend\n"
             "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
    }
  } // namespace test
} // namespace emmy

#endif
