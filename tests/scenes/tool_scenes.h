#ifndef emmy_tests_scenes_tool_scenes_h
#define emmy_tests_scenes_tool_scenes_h

// The scenes of tests/scenes/tools.cc, which says what must hold of them.

#include <deal.II/base/numbers.h>

#include <cmath>

#include "tool_case.h"

namespace emmy
{
  namespace test
  {
    /** What the prototype has. */
    inline const std::string of_prototype =
      "set Geometry = start\nset Starved nodes = free\n";

    /** A unit cube that a plate presses to three quarters in 1 s. */
    inline ToolCase
    press(const std::string &stiffness)
    {
      ToolCase result;
      result.walls = "x-min, y-min";
      result.time  = "set Step size = 0.05\nset End time = 1\n";
      result.tools =
        plate("0.5, 1",
              "0, -1",
              "set Displacement = 0; -0.25*t\n" +
                (stiffness.empty() ? std::string()
                                   : "set Stiffness = " + stiffness + "\n"));
      return result;
    }

    /** A block on a slope, with friction of 0.5, in axes of the slope. */
    inline ToolCase
    slope(const double degrees)
    {
      const double angle = degrees / 180. * dealii::numbers::PI;
      ToolCase     result;
      result.upper        = "6, 2.5";
      result.cells        = "24, 10";
      result.lower_of_box = "0.5, 0.5";
      result.upper_of_box = "1.5, 1.5";
      result.points       = 4;
      result.density      = 1000.;
      result.poisson      = 0.3;
      result.effects      = "gravity, tools";
      result.sections     = "subsection Gravity\nset Acceleration = " +
                        shortest(10. * std::sin(angle)) + ", " +
                        shortest(-10. * std::cos(angle)) +
                        "\nset Amplitude table = 0: 0, 0.3: 1\nend\n";
      result.method = of_prototype + "set Shape functions = linear\n";
      result.time   = "set Step size = 0.02\nset End time = 1\n";
      result.tools =
        plate("0, 0.5", "0, 1", "set Friction coefficient = 0.5\n");
      return result;
    }

    /** A bar in a tube whose end a plane moves, by 1 m of 2 m. */
    inline ToolCase
    tube(const bool draws)
    {
      ToolCase result;
      result.upper        = draws ? "4, 1" : "2, 1";
      result.cells        = draws ? "16, 4" : "8, 4";
      result.upper_of_box = "2, 1";
      result.density      = 1000.;
      result.modulus      = 1e5;
      result.walls = draws ? "x-min, y-min, y-max" : "x-max, y-min, y-max";
      result.time  = "set Step size = 0.1\nset End time = 20\n";
      result.tools =
        plate(draws ? "2, 0" : "0, 0",
              draws ? "-1, 0" : "1, 0",
              std::string(
                "set Displacement = 0.05*t; 0\nset Stiffness = 100\n") +
                (draws ? "set Holds = true\n" : ""));
      return result;
    }

    /** A ball that flies against a plane; it may overlap it at the start. */
    template <int dim>
    ToolCase
    bounce(const std::string &height, const std::string &solver = "")
    {
      ToolCase result;
      result.dim   = dim;
      result.upper = dim == 2 ? "3, 3" : "2, 2, 2";
      result.cells = dim == 2 ? "12, 12" : "8, 8, 8";
      result.shape = std::string("set Shape = ball\nsubsection ball\n") +
                     "set Center = " + (dim == 2 ? "1.5, 1.2" : "1, 1.1, 1") +
                     "\nset Radius = 0.5\nend\n";
      result.velocity = dim == 2 ? "0.1; -0.5" : "0.1; -0.5; 0";
      result.density  = 1000.;
      result.modulus  = 1e6;
      result.poisson  = 0.3;
      result.time     = "set Step size = 0.01\nset End time = 1\n";
      result.tools =
        plate((dim == 2 ? "0, " : "0, ") + height + (dim == 2 ? "" : ", 0"),
              dim == 2 ? "0, 1" : "0, 1, 0",
              "set Friction coefficient = 0.3\n");
      result.sections = solver;
      return result;
    }

    /**
     * A mass of 100 bars falls on a bar of 1 m in a tube: by Hooke's law it
     * presses by v sqrt(E m) at most and flies off after pi sqrt(m/E), as fast
     * as it came. Of the bar's own mass a third swings along; 1 % is left to
     * its waves. These, undamped, bring the force up to 1 + sqrt(1/100) times
     * that (Boussinesq); cells and steps smooth them.
     */
    inline ToolCase
    drop()
    {
      ToolCase result;
      result.walls        = "x-min, x-max, y-min";
      result.upper        = "0.5, 1.5";
      result.cells        = "2, 6";
      result.upper_of_box = "0.5, 1";
      result.density      = 10.;
      result.time         = "set Step size = 0.001\nset End time = 1\n";
      result.tools =
        plate("0, 1.0001",
              "0, -1",
              "set Pushed along = 0, -1\nset Force = 0\nset Mass = 500\n"
              "set Initial speed = 0.2\nset Stiffness = 100\n");
      return result;
    }
  } // namespace test
} // namespace emmy

#endif
