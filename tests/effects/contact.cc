// Facts about the effect contact: bodies that meet, rub and part keep all
// balances; the equation of a step has the derivative that it says, whether
// places stay or follow; bodies of several velocity fields are as if alone
// where nothing pushes them; what cannot be is refused.

#include <emmy/effects/contact_pair.h>

#include "tangent.h"

using namespace emmy;
using test::at_most;
using test::check;

namespace
{
  /** Two blocks of two materials that meet, and perhaps a third. */
  template <int dim>
  struct Blocks
  {
    std::string geometry = "start";
    std::string left_speed =
      dim == 2 ? "1 + 0.3*y; 0.2*x" : "1 + 0.3*y; 0.2*x; 0.1*y";
    std::string names = "left, right", effects = "contact",
                contact = "set Groups = left | right\n"
                          "set Friction coefficient = 0.4\n";
    std::string starved = "set Starved nodes = follow\n"
                          "set Starved threshold = 0.1\n";

    std::string
    text() const
    {
      const auto in = [](const std::string &plane, const std::string &space) {
        return dim == 2 ? plane : space;
      };
      return "set Dimension = " + std::to_string(dim) +
             "\nsubsection Grid\nset Lower corner = " + in("0, 0", "0, 0, 0") +
             "\nset Upper corner = " + in("4, 2.5", "4, 2.5, 2.5") +
             "\nset Cells = " + in("8, 5", "8, 5, 5") +
             "\nend\nsubsection Method\nset Geometry = " + geometry + "\n" +
             starved +
             "end\nsubsection Materials\nset Names = m, n\nsubsection m\n"
             "set Model = Hencky\nset Density = 5\n"
             "set Young's modulus = 100\nset Poisson's ratio = 0.3\nend\n"
             "subsection n\nset Model = Hencky\nset Density = 3\n"
             "set Young's modulus = 70\nset Poisson's ratio = 0.2\nend\nend\n"
             "subsection Bodies\nset Names = " +
             names +
             "\nsubsection left\nset Shape = box\nset Material = m\n"
             "set Points per direction = 2\nset Initial velocity = " +
             left_speed + "\nsubsection box\nset Lower corner = " +
             in("0.5, 0.5", "0.5, 0.5, 0.5") +
             "\nset Upper corner = " + in("1.5, 1.5", "1.5, 1.5, 1.5") +
             "\nend\nend\nsubsection right\nset Shape = box\nset Material = "
             "n\nset Points per direction = 3\nset Initial velocity = " +
             in("-0.8; 0.4", "-0.8; 0.4; 0.2") +
             "\nsubsection box\nset Lower corner = " +
             in("1.75, 0.75", "1.75, 0.75, 0.75") +
             "\nset Upper corner = " + in("2.25, 1.75", "2.25, 1.75, 1.25") +
             "\nend\nend\nend\nsubsection Effects\nset Names = " + effects +
             "\nsubsection Contact\n" + contact +
             "end\nend\nsubsection Time\nset End time = 1\n"
             "set Step rule = fixed\nset Step size = 0.04\nend\n"
             "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
    }
  };

  /** Balances of a run, and that all that can happen does. */
  template <int dim>
  void
  check_run(const std::string &geometry)
  {
    Blocks<dim> blocks;
    blocks.geometry = geometry;
    const SceneParameters<dim> parameters(
      ParameterFile::from_text(blocks.text(), "test"));
    test::RunningScene<dim> run(parameters);
    run.advance(dim == 2 ? 20 : 8);
    const std::string what  = std::to_string(dim) + "D, " + geometry + ": ";
    const double      scale = test::largest(run.column("kinetic_energy"));
    at_most(what + "balance of energy",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    const auto lost = run.column("friction_dissipation");
    at_most(what + "slip that gives energy",
            -test::least_change(lost) / scale,
            1e-15);
    for (const char *column :
         {"contact_energy", "friction_energy", "friction_dissipation"})
      check(test::largest(run.column(column)) > 1e-6 * scale,
            what + "there is " + column);
    for (unsigned int d = 0; d < dim; ++d)
      {
        const std::string axis(1, "xyz"[d]);
        const auto        momentum = run.column("linear_momentum_" + axis),
                   on_left         = run.column("contact_left_force_" + axis),
                   on_right        = run.column("contact_right_force_" + axis);
        double left                = 0.;
        for (unsigned int row = 0; row < on_left.size(); ++row)
          left = std::max(left, std::abs(on_left[row] + on_right[row]));
        at_most(what + "force without a counterforce",
                left / test::largest(on_left),
                1e-14);
        at_most(what + "linear momentum made",
                std::abs(momentum.back() - momentum.front()) /
                  test::largest(run.column("linear_momentum_x")),
                1e-12);
      }
    for (unsigned int d = dim == 2 ? 2 : 0; d < 3; ++d)
      {
        const auto spin =
          run.column(std::string("angular_momentum_") + "xyz"[d]);
        at_most(what + "angular momentum made",
                std::abs(spin.back() - spin.front()) /
                  test::largest(run.column("angular_momentum_z")),
                geometry == "start" ? 1e-12 : 1e-10);
      }
  }

  /**
   * Contact points are where the step before has left them: once bodies have
   * parted nothing is stored, also where no box keeps F.
   */
  void
  check_parting(const std::string &geometry)
  {
    Blocks<2> blocks;
    blocks.geometry = geometry;
    blocks.starved += "set Shape functions = linear\n";
    const SceneParameters<2> parameters(
      ParameterFile::from_text(blocks.text(), "test"));
    test::RunningScene<2> run(parameters);
    run.advance(25);
    const auto stored = run.column("contact_energy");
    check(run.ledger["contact_pairs"] == 0., geometry + ": they have parted");
    at_most(geometry + ", parted: energy of contact that is left",
            std::abs(stored.back()) / test::largest(stored),
            1e-12);
  }

  /**
   * Where nothing pushes, the ledger of both is the sum of those of each: they
   * go through one another, also where nodes starve.
   */
  void
  check_fields(const std::string &geometry, const std::string &starved)
  {
    std::vector<std::vector<double>> sums;
    const std::vector<std::string>   columns{"kinetic_energy",
                                           "strain_energy",
                                           "linear_momentum_x",
                                           "linear_momentum_y",
                                           "angular_momentum_z",
                                           "active_cells",
                                           "active_dofs",
                                           "particles"};
    for (const std::string names : {"left", "right", "left, right"})
      {
        Blocks<2> blocks;
        blocks.geometry = geometry;
        blocks.names    = names;
        blocks.starved  = starved;
        // the left one is to cross the right one
        blocks.left_speed = "2 + 0.6*y; 0.4*x";
        if (names == "left, right")
          blocks.contact = "set Groups = left | right\n"
                           "set Stiffness factor = 0\n";
        else
          blocks.effects = blocks.contact = "";
        std::string text = blocks.text();
        if (names != "left, right")
          {
            // sections of bodies that are not there are refused
            const std::string other =
              names == "left" ? "subsection right" : "subsection left";
            const auto begin = text.find(other),
                       end   = text.find(names == "left" ? "end\nsubsection Eff"
                                                       : "subsection right");
            text.erase(begin, end - begin);
            const auto contact = text.find("subsection Contact");
            text.erase(contact,
                       std::string("subsection Contact\nend\n").size());
          }
        const SceneParameters<2> parameters(
          ParameterFile::from_text(text, "test"));
        test::RunningScene<2> run(parameters);
        run.most_residual_work = 1e-8;
        run.advance(20);
        for (unsigned int i = 0; i < columns.size(); ++i)
          {
            const auto column = run.column(columns[i]);
            if (names == "left")
              sums.push_back(column);
            else if (names == "right")
              for (unsigned int row = 0; row < column.size(); ++row)
                sums[i][row] += column[row];
            else
              {
                double error = 0.;
                for (unsigned int row = 0; row < column.size(); ++row)
                  error = std::max(error, std::abs(sums[i][row] - column[row]));
                at_most(geometry + ", " + columns[i] + " of two and of each",
                        error / test::largest(column),
                        // nodes of next to no mass: what solves may leave
                        starved.find("free") != std::string::npos ? 1e-8
                                                                  : 1e-10);
              }
          }
      }
  }

  /**
   * Two lattices of contact points without end, one shifted over the other at
   * many heights, which are pressures of 0.15 to 2.2 beta M for the default:
   * the largest force along their face, of that across it.
   */
  double
  ripple(const double radius, const unsigned int exponent)
  {
    const PairLaw law{1., radius, exponent, 0.5, 0., 1.};
    double        largest = 0.;
    for (double height = 0.9; height < std::min(2.05, radius); height += 0.1)
      for (double shift = 0.; shift < 1.; shift += 0.05)
        {
          // on a column of the upper one, of spacing 1
          dealii::Tensor<1, 2> force;
          for (int row = 0; row < 4; ++row)
            for (int below = 0; below < 4; ++below)
              for (int along = -4; along <= 4; ++along)
                {
                  PairPoint<2> upper{}, lower{};
                  upper.particle[0] = shift;
                  upper.particle[1] = height + row;
                  lower.particle[0] = along;
                  lower.particle[1] = -below;
                  force +=
                    pair_action(law, upper, lower, dealii::Tensor<1, 2>())
                      .force;
                }
          largest = std::max(largest, std::abs(force[0]) / force[1]);
        }
    return largest;
  }

  void
  check_refusals()
  {
    const auto refused = [](const std::string              &contact,
                            const std::vector<std::string> &words) {
      Blocks<2> blocks;
      blocks.contact = contact;
      test::check_throws_with(
        [&] {
          const SceneParameters<2> parameters(
            ParameterFile::from_text(blocks.text(), "test"));
          Scene<2> scene(parameters, MPI_COMM_WORLD);
        },
        words);
    };
    refused("", {"Groups", "at least two"});
    refused("set Groups = left, right\n", {"Groups", "at least two"});
    refused("set Groups = left | rihgt\n", {"rihgt", "Did you mean <right>?"});
    refused("set Groups = left | right, left\n", {"named twice"});
    refused("set Groups = left | right\nset Radius = 0\n",
            {"Radius", "positive"});
    refused("set Groups = left | right\nset Friction coefficient = -1\n",
            {"Friction coefficient", "must not be negative"});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const std::string geometry : {"start", "middle"})
    {
      check_fields(geometry,
                   "set Starved nodes = follow\nset Starved threshold = 0.1\n");
      check_run<2>(geometry);
      check_run<3>(geometry);
      check_parting(geometry);
    }
  check_fields("start", "set Starved nodes = free\n");
  Blocks<2> plane;
  Blocks<3> space;
  test::check_tangent_of_start<2>(plane.text());
  test::check_tangent_of_start<3>(space.text());
  plane.geometry = space.geometry = "middle";
  test::check_tangent_of_middle<2>(plane.text());
  test::check_tangent_of_middle<3>(space.text());
  at_most("ripple of the default", ripple(2.5, 3), 0.02);
  at_most("ripple of narrow points found, less than", 0.3, ripple(1., 2));
  check_refusals();
  return test::report();
}
