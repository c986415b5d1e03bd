#ifndef emmy_tests_scene_h
#define emmy_tests_scene_h

#include <emmy/output/ledger.h>
#include <emmy/study/scene.h>

#include <fstream>
#include <string>

namespace emmy
{
  namespace test
  {
    /** A scene that runs in memory, with its ledger. */
    template <int dim>
    struct RunningScene
    {
      Scene<dim> scene;
      Ledger     ledger;

      RunningScene(const SceneParameters<dim> &parameters,
                   const MPI_Comm              communicator = MPI_COMM_WORLD)
        : scene(parameters, communicator)
        , ledger(scene.stepper.initial_report(), dim)
      {}

      void
      advance(const unsigned int n_steps)
      {
        for (unsigned int i = 0; i < n_steps; ++i)
          ledger.add(scene.stepper.advance());
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

    /** Two discs or balls that collide off their axis. */
    inline std::string
    collision_text(const unsigned int dim, const unsigned int points)
    {
      const std::string zero = dim == 2 ? "" : "; 0",
                        mid  = dim == 2 ? "" : ", 1.5";
      return "set Dimension = " + std::to_string(dim) +
             "\n"
             "subsection Grid\n"
             "set Lower corner = 0, 0" +
             (dim == 2 ? "" : ", 0") + "\nset Upper corner = 6, 4" +
             (dim == 2 ? "" : ", 3") + "\nset Cells = 12, 8" +
             (dim == 2 ? "" : ", 6") +
             "\nend\n"
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
             std::to_string(points) + "\nset Initial velocity = 0.9; 0.1" +
             zero + "\nsubsection ball\nset Center = 1.9, 1.8" + mid +
             "\nset Radius = 0.8\nend\nend\n"
             "subsection right\n"
             "set Shape = ball\nset Material = cork\n"
             "set Points per direction = " +
             std::to_string(points) + "\nset Initial velocity = -0.7; 0" +
             zero + "\nsubsection ball\nset Center = 4, 2.3" + mid +
             "\nset Radius = 0.9\nend\nend\nend\n"
             "subsection Time\nset End time = 2\n"
             "set Step rule = normalised\nset Factor = 0.4\nend\n"
             "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
    }
  } // namespace test
} // namespace emmy

#endif
