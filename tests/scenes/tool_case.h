#ifndef emmy_tests_scenes_tool_case_h
#define emmy_tests_scenes_tool_case_h

// The scenes with tools that a test writes.

#include <emmy/base/text.h>
#include <emmy/run/scene.h>

#include <string>

namespace emmy
{
  namespace test
  {
    /** A square or cube of 1 m, or a ball, and what acts on it. */
    struct ToolCase
    {
      unsigned int dim   = 2;
      std::string  upper = "1.25, 1.25", cells = "5, 5";
      std::string  lower_of_box = "0, 0", upper_of_box = "1, 1";
      std::string  shape; ///< in place of the box
      std::string  velocity = "";
      unsigned int points   = 2;
      double       density = 1., modulus = 1e6, poisson = 0.;
      std::string  walls = "", effects = "tools", sections, method, time;
      std::string  tools;

      std::string
      text() const
      {
        return "set Dimension = " + std::to_string(dim) +
               "\nsubsection Grid\nset Lower corner = " +
               (dim == 2 ? "0, 0" : "0, 0, 0") +
               "\nset Upper corner = " + upper + "\nset Cells = " + cells +
               "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
               "set Model = Hencky\nset Density = " +
               shortest(density) +
               "\nset Young's modulus = " + shortest(modulus) +
               "\nset Poisson's ratio = " + shortest(poisson) +
               "\nend\nend\nsubsection Bodies\nset Names = body\n"
               "subsection body\nset Material = m\nset Initial velocity = " +
               velocity +
               "\nset Points per direction = " + std::to_string(points) + "\n" +
               (shape.empty() ? "set Shape = box\nsubsection box\n"
                                "set Lower corner = " +
                                  lower_of_box + "\nset Upper corner = " +
                                  upper_of_box + "\nend\n"
                              : shape) +
               "end\nend\nsubsection Boundary conditions\nset Roller = " +
               walls + "\nend\nsubsection Effects\nset Names = " + effects +
               "\n" + sections + "subsection Tools\n" + tools +
               "end\nend\nsubsection Method\n" + method +
               "end\nsubsection Time\nset Step rule = fixed\n" + time +
               "end\nsubsection Solver\nset Newton tolerance = 1e-15\nend\n";
      }
    };

    /** A smooth plate, as a section; more statements for it. */
    inline std::string
    plate(const std::string &point,
          const std::string &normal,
          const std::string &more)
    {
      return "set Names = plate\nsubsection plate\nset Shape = plane\n"
             "set Reference point = " +
             point + "\n" + more + "subsection plane\nset Normal = " + normal +
             "\nend\nend\n";
    }
    /** Where the body's middle is, and how fast. */
    template <int dim>
    std::pair<dealii::Tensor<1, dim>, dealii::Tensor<1, dim>>
    middle_of(const Scene<dim> &scene)
    {
      dealii::Tensor<1, dim> x, v;
      double                 mass = 0.;
      for (const auto &particle : scene.particles)
        {
          const auto   values = particle.get_properties();
          const double m      = values[scene.layout["mass"]];
          mass += m;
          x += m * dealii::Tensor<1, dim>(particle.get_location());
          for (unsigned int d = 0; d < dim; ++d)
            v[d] += m * values[scene.layout["velocity"] + d];
        }
      mass = dealii::Utilities::MPI::sum(mass, scene.grid.communicator());
      return {dealii::Utilities::MPI::sum(x, scene.grid.communicator()) / mass,
              dealii::Utilities::MPI::sum(v, scene.grid.communicator()) / mass};
    }

  } // namespace test
} // namespace emmy

#endif
