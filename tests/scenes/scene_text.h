#ifndef emmy_tests_scenes_scene_text_h
#define emmy_tests_scenes_scene_text_h

#include <regex>

#include "../check.h"
#include "../scene.h"

// Scenes as text, written as they look after a motion, and compared.
namespace emmy
{
  namespace test
  {
    inline const std::vector<std::string> axes{"x", "y", "z"};

    using Numbers = std::vector<double>;

    /** A body; its velocity is formulas in X, Y, Z. */
    struct BodyText
    {
      std::string              name, material;
      unsigned int             points;
      std::vector<std::string> velocity;
      Numbers                  lower, upper; ///< of a box; else empty
      Numbers                  centre;       ///< of a ball
      double                   radius;
    };

    struct SceneText
    {
      Numbers                  lower, upper; ///< of the grid
      std::vector<int>         cells;
      std::string              materials; ///< the section
      std::vector<BodyText>    bodies;
      std::vector<std::string> rollers = {}; ///< e.g. "Y-min"
      Numbers                  gravity = {}, force = {}, loaded = {};
      /** Where particles are measured, by name. */
      std::vector<std::pair<std::string, Numbers>> measured = {};
      std::string                                  rest;

      unsigned int
      dim() const
      {
        return lower.size();
      }
    };

    /**
     * New axis i is old axis `from[i]`, reversed if `sign[i]` is -1: the grid
     * keeps its ends.
     */
    struct Motion
    {
      std::vector<unsigned int> from;
      Numbers                   sign;
    };

    inline std::string
    list(const std::vector<std::string> &items, const std::string &separator)
    {
      return join(items, separator);
    }

    /** Writes a scene as it looks after a motion. */
    class Writer
    {
    public:
      Writer(const SceneText &scene, const Motion &motion)
        : scene(scene)
        , motion(motion)
      {}

      std::string
      text() const
      {
        const std::string dim = std::to_string(scene.dim());
        std::string       cells;
        for (const unsigned int axis : motion.from)
          cells +=
            (cells.empty() ? "" : ", ") + std::to_string(scene.cells[axis]);
        std::string result = "set Dimension = " + dim + "\nsubsection Grid\n" +
                             corners(scene.lower, scene.upper) +
                             "set Cells = " + cells + "\nend\n" +
                             scene.materials + "subsection Bodies\n";
        std::vector<std::string> names;
        for (const BodyText &body : scene.bodies)
          {
            names.push_back(body.name);
            result += of(body);
          }
        result += "set Names = " + join(names) + "\nend\n" + effects();
        std::vector<std::string> rollers, measured;
        for (const std::string &side : scene.rollers)
          rollers.push_back(moved_side(side));
        if (!rollers.empty())
          result +=
            "subsection Boundary conditions\nset Roller = " + join(rollers) +
            "\nend\n";
        std::string sections;
        for (const auto &[name, place] : scene.measured)
          {
            measured.push_back(name);
            sections += "subsection " + name +
                        "\nset Type = particle\nset Nearest to = " +
                        written(moved(place), ", ") + "\nend\n";
          }
        return result +
               "subsection Measurements\nset Names = " + join(measured) + "\n" +
               sections + "end\n" + scene.rest +
               "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
      }

      /** A position after the motion. */
      Numbers
      moved(const Numbers &x) const
      {
        Numbers result;
        for (unsigned int i = 0; i < scene.dim(); ++i)
          {
            const unsigned int a = motion.from[i];
            result.push_back(motion.sign[i] > 0.
                               ? x[a]
                               : scene.lower[a] + scene.upper[a] - x[a]);
          }
        return result;
      }

      /** A vector after the motion. */
      Numbers
      turned(const Numbers &v) const
      {
        Numbers result;
        for (unsigned int i = 0; i < scene.dim(); ++i)
          result.push_back(motion.sign[i] * v[motion.from[i]]);
        return result;
      }

      /** Whether the motion mirrors: -1, else 1. In the plane. */
      double
      handedness() const
      {
        return motion.sign[0] * motion.sign[1] *
               (motion.from[0] == 0 ? 1. : -1.);
      }

    private:
      static std::string
      written(const Numbers &numbers, const std::string &separator)
      {
        std::vector<std::string> items;
        for (const double number : numbers)
          items.push_back(shortest(number));
        return list(items, separator);
      }

      std::string
      corners(const Numbers &lower, const Numbers &upper) const
      {
        Numbers a = moved(lower), b = moved(upper);
        for (unsigned int d = 0; d < a.size(); ++d)
          if (a[d] > b[d])
            std::swap(a[d], b[d]);
        return "set Lower corner = " + written(a, ", ") +
               "\nset Upper corner = " + written(b, ", ") + "\n";
      }

      /** Formulas of old coordinates as formulas of new ones. */
      std::string
      velocity(const std::vector<std::string> &formulas) const
      {
        std::vector<std::string> items;
        for (unsigned int i = 0; i < scene.dim(); ++i)
          {
            std::string formula = formulas[motion.from[i]];
            for (unsigned int j = 0; j < scene.dim(); ++j)
              {
                const unsigned int a = motion.from[j];
                const std::string  x =
                  motion.sign[j] > 0.
                     ? axes[j]
                     : "(" + shortest(scene.lower[a] + scene.upper[a]) + "-" +
                        axes[j] + ")";
                const char capital = "XYZ"[a];
                formula =
                  std::regex_replace(formula,
                                     std::regex(std::string(1, capital)),
                                     x);
              }
            items.push_back((motion.sign[i] > 0. ? "" : "-") +
                            ("(" + formula + ")"));
          }
        return list(items, "; ");
      }

      std::string
      of(const BodyText &body) const
      {
        const bool is_box = body.centre.empty();
        return "subsection " + body.name +
               "\nset Shape = " + (is_box ? "box" : "ball") +
               "\nset Material = " + body.material +
               "\nset Points per direction = " + std::to_string(body.points) +
               "\nset Initial velocity = " + velocity(body.velocity) +
               "\nsubsection " +
               (is_box
                  ? "box\n" + corners(body.lower, body.upper)
                  : "ball\nset Center = " + written(moved(body.centre), ", ") +
                      "\nset Radius = " + shortest(body.radius) + "\n") +
               "end\nend\n";
      }

      std::string
      effects() const
      {
        std::string names, sections;
        if (!scene.gravity.empty())
          {
            names = "gravity";
            sections += "subsection Gravity\nset Acceleration = " +
                        written(turned(scene.gravity), ", ") + "\nend\n";
          }
        if (!scene.force.empty())
          {
            names += std::string(names.empty() ? "" : ", ") + "point load";
            sections += "subsection Point load\nset Force = " +
                        written(turned(scene.force), "; ") +
                        "\nset Points nearest to = " +
                        written(moved(scene.loaded), ", ") + "\nend\n";
          }
        return "subsection Effects\nset Names = " + names + "\n" + sections +
               "end\n";
      }

      std::string
      moved_side(const std::string &side) const
      {
        const unsigned int axis = side[0] - 'X';
        for (unsigned int i = 0; i < scene.dim(); ++i)
          if (motion.from[i] == axis)
            return axes[i] + ((side == std::string(1, side[0]) + "-min") ==
                                  (motion.sign[i] > 0.)
                                ? "-min"
                                : "-max");
        return "";
      }

      const SceneText &scene;
      const Motion    &motion;
    };

    /** The ledgers of a scene and of the same scene told in another way. */
    template <int dim>
    class Comparison
    {
    public:
      Comparison(const SceneText   &scene,
                 const unsigned int n_steps,
                 const std::string &name)
        : scene(scene)
        , n_steps(n_steps)
        , name(name)
        , parameters(
            ParameterFile::from_text(Writer(scene, as_it_is).text(), name))
        , run(parameters, MPI_COMM_SELF)
      {
        run.advance(n_steps);
        for (const char *column : {"kinetic_energy", "strain_energy"})
          energy = std::max(energy, test::largest(run.column(column)));
        for (const auto &particle : run.scene.particles)
          mass += particle.get_properties()[run.scene.layout["mass"]];
        if (is_first)
          std::cout << name << ": followers up to "
                    << test::largest(run.column("followers")) << ", changes "
                    << total(run.column("class_changes")) << '\n';
      }

      const test::RunningScene<dim> &
      told() const
      {
        return run;
      }

      void
      check(const std::string &relation,
            const SceneText   &other,
            const Motion      &motion = as_it_is) const
      {
        const Writer               writer(other, motion);
        const SceneParameters<dim> parameters(
          ParameterFile::from_text(writer.text(), name + ", " + relation));
        test::RunningScene<dim> again(parameters, MPI_COMM_WORLD);
        again.advance(n_steps);
        double worst = 0.;
        for (const std::string &column : run.ledger.columns())
          {
            const bool is_energy = column.find("energy") != std::string::npos ||
                                   column == "plastic_dissipation" ||
                                   column == "load_work";
            const bool is_count = column == "followers" ||
                                  column == "class_changes" ||
                                  column == "active_dofs" || column == "time";
            if (is_energy || is_count)
              worst = std::max(worst,
                               distance(run.column(column),
                                        again.column(column),
                                        is_energy ? energy : 1.));
          }
        worst = std::max(worst, of_momenta(again, writer));
        worst = std::max(worst, of_paths(again, writer));
        if (is_first)
          test::at_most(name + ", " + relation, worst, 1e-12);
        else
          test::check(worst <= 1e-12, name + ", " + relation);
      }

      static const Motion as_it_is;

    private:
      static double
      total(const Numbers &values)
      {
        double sum = 0.;
        for (const double value : values)
          sum += value;
        return sum;
      }

      static double
      distance(const Numbers &a, const Numbers &b, const double scale)
      {
        if (a.size() != b.size())
          return std::numeric_limits<double>::infinity();
        Numbers difference;
        for (unsigned int i = 0; i < a.size(); ++i)
          difference.push_back(a[i] - b[i]);
        return test::largest(difference) / scale;
      }

      /** A vector in the rows of a run: columns PREFIX_x and so on. */
      static std::vector<Numbers>
      vectors(const test::RunningScene<dim> &of, const std::string &prefix)
      {
        std::vector<Numbers> rows(of.ledger.rows().size());
        for (unsigned int d = 0; d < dim; ++d)
          {
            const auto values = of.column(prefix + "_" + axes[d]);
            for (unsigned int row = 0; row < rows.size(); ++row)
              rows[row].push_back(values[row]);
          }
        return rows;
      }

      double
      of_momenta(const test::RunningScene<dim> &again,
                 const Writer                  &writer) const
      {
        const double scale = std::sqrt(2. * mass * energy);
        const auto   told  = vectors(run, "linear_momentum"),
                   retold  = vectors(again, "linear_momentum");
        double worst       = 0.;
        for (unsigned int row = 0; row < told.size(); ++row)
          worst =
            std::max(worst,
                     distance(writer.turned(told[row]), retold[row], scale));
        if (dim == 2)
          {
            // about the origin, which the motion moves
            const auto J       = run.column("angular_momentum_z"),
                       J_new   = again.column("angular_momentum_z");
            const Numbers o    = writer.moved({0., 0.});
            const double  size = scale * (scene.upper[0] - scene.lower[0] +
                                         std::abs(o[0]) + std::abs(o[1]));
            for (unsigned int row = 0; row < J.size(); ++row)
              worst =
                std::max(worst,
                         std::abs(J_new[row] - writer.handedness() * J[row] -
                                  o[0] * retold[row][1] +
                                  o[1] * retold[row][0]) /
                           size);
          }
        return worst;
      }

      double
      of_paths(const test::RunningScene<dim> &again, const Writer &writer) const
      {
        double worst = 0.;
        for (const auto &[point, place] : scene.measured)
          {
            const auto told   = vectors(run, point),
                       retold = vectors(again, point);
            for (unsigned int row = 0; row < told.size(); ++row)
              worst = std::max(worst,
                               distance(writer.moved(told[row]),
                                        retold[row],
                                        scene.upper[0] - scene.lower[0]));
          }
        return worst;
      }

      const SceneText            scene;
      const unsigned int         n_steps;
      const std::string          name;
      const SceneParameters<dim> parameters;
      test::RunningScene<dim>    run;
      double                     energy = 0., mass = 0.;
      const bool                 is_first =
        dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
    };

    template <>
    inline const Motion Comparison<2>::as_it_is{{0, 1}, {1., 1.}};
    template <>
    inline const Motion Comparison<3>::as_it_is{{0, 1, 2}, {1., 1., 1.}};

    inline SceneText
    renamed(SceneText scene)
    {
      for (BodyText &body : scene.bodies)
        body.name = "z" + std::string(body.name.rbegin(), body.name.rend());
      return scene;
    }

    inline SceneText
    reordered(SceneText scene)
    {
      std::reverse(scene.bodies.begin(), scene.bodies.end());
      return scene;
    }

    /** A box, as two that touch at a place of an axis. */
    inline SceneText
    cut(SceneText          scene,
        const unsigned int body,
        const unsigned int axis,
        const double       place)
    {
      BodyText upper    = scene.bodies[body];
      upper.name        = scene.bodies[body].name + " part " + axes[axis];
      upper.lower[axis] = scene.bodies[body].upper[axis] = place;
      scene.bodies.push_back(upper);
      return scene;
    }
  } // namespace test
} // namespace emmy

#endif
