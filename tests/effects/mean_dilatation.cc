// Facts about the treatment of locking: the equation of a step has the
// derivative that it says, whether places stay or follow, in steps in time and
// in static ones; runs over many cells keep all balances and momenta, on any
// number of ranks; a body cut in two is as one; what cannot be is refused; who
// does not ask for it has none of its fields; a scene can have bodies of both
// kinds.

#include "tangent.h"
#include <emmy/effects/mean_dilatation.h>

using namespace emmy;
using test::at_most;
using test::check;

namespace
{
  /** A block, perhaps cut into bodies that touch within cells. */
  template <int dim>
  std::string
  bodies(const unsigned int n_bodies)
  {
    const auto in = [](const std::string &plane, const std::string &space) {
      return dim == 2 ? plane : space;
    };
    const auto part = [&](const std::string &name,
                          const std::string &lower,
                          const std::string &upper) {
      return "subsection " + name +
             "\nset Shape = box\nset Material = m\nset Points per direction = "
             "2\nset Initial velocity = 1 - (y - 1.9) + 0.5*(x - 2.1); "
             "0.5 + (x - 2.1) - 0.4*(y - 1.9)" +
             in("", "; 0.3*(x - 2.1)") +
             "\nsubsection box\nset Lower corner = " + lower + ", 1" +
             in("", ", 1") + "\nset Upper corner = " + upper + ", 2.5" +
             in("", ", 2") + "\nend\nend\n";
    };
    // 1.75 is in the middle of a cell
    return "subsection Bodies\n" +
           (n_bodies == 1 ? "set Names = block\n" + part("block", "1", "3")
                          : "set Names = a, b\n" + part("a", "1", "1.75") +
                              part("b", "1.75", "3")) +
           "end\n";
  }

  /** A block that flies, turns, breathes and flows. */
  template <int dim>
  std::string
  block(const std::string &method,
        const std::string &more,
        const unsigned int n_bodies = 1)
  {
    const auto in = [](const std::string &plane, const std::string &space) {
      return dim == 2 ? plane : space;
    };
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Grid\nset Lower corner = " + in("0, 0", "0, 0, 0") +
           "\nset Upper corner = " + in("5, 5", "4, 4, 3") +
           "\nset Cells = " + in("10, 10", "8, 8, 6") +
           "\nend\nsubsection Method\nset Locking treatment = cell\n" + method +
           "end\nsubsection Materials\nset Names = m\nsubsection m\n"
           "set Model = von Mises\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.45\n"
           "set Yield stress = " +
           in("12", "4") + "\nset Hardening modulus = 10\nend\nend\n" +
           bodies<dim>(n_bodies) + more +
           "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
  }

  const std::string in_time = "subsection Time\nset End time = 9\n"
                              "set Step rule = fixed\nset Step size = 0.04\n"
                              "end\n";

  template <int dim>
  SceneParameters<dim>
  parsed(const std::string &text)
  {
    return SceneParameters<dim>(ParameterFile::from_text(text, "test"));
  }

  template <int dim>
  void
  check_tangent_of_start(const std::string &functions)
  {
    test::check_tangent_of_start<dim>(
      block<dim>("set Geometry = start\nset Starved nodes = follow\n"
                 "set Shape functions = " +
                   functions + "\n",
                 in_time),
      "start, " + functions,
      3);
  }

  template <int dim>
  void
  check_tangent_of_middle(const std::string &functions,
                          const std::string &update)
  {
    test::check_tangent_of_middle<dim>(
      block<dim>("set Geometry = middle\nset Starved nodes = follow\n"
                 "set Domain update = " +
                   update + "\nset Shape functions = " + functions + "\n",
                 in_time),
      "middle, " + functions + ", " + update,
      3);
  }

  /** Balances of a run over cells, and what it comes to. */
  template <int dim>
  std::vector<double>
  run_block(const std::string &method,
            const std::string &what,
            const unsigned int n_bodies     = 1,
            const MPI_Comm     communicator = MPI_COMM_WORLD)
  {
    const auto parameters = parsed<dim>(block<dim>(method, in_time, n_bodies));
    test::RunningScene<dim> run(parameters, communicator);
    run.advance(dim == 2 ? 30 : 10);
    const double scale        = test::largest(run.column("kinetic_energy"));
    const bool   is_at_middle = what.find("middle") != std::string::npos;
    at_most(what + ": balance of energy",
            test::largest(run.column("balance_error")) / scale,
            1e-12);
    check(run.ledger["plastic_dissipation"] > 1e-3 * scale, what + ": flows");
    for (const char *name : {"linear_momentum_x", "angular_momentum_z"})
      {
        const auto column = run.column(name);
        at_most(what + ": change of " + name,
                std::abs(column.back() - column.front()) /
                  test::largest(column),
                is_at_middle ? 1e-8 : 1e-11);
      }
    return {run.ledger["kinetic_energy"],
            run.ledger["strain_energy"],
            run.ledger["plastic_dissipation"],
            run.ledger["angular_momentum_z"]};
  }

  /** On all ranks, on each alone, and with a body that is cut. */
  template <int dim>
  void
  check_alike(const std::string &method, const std::string &what)
  {
    const auto all = run_block<dim>(method, what),
               alone =
                 run_block<dim>(method, what + ", alone", 1, MPI_COMM_SELF),
               cut = run_block<dim>(method, what + ", cut", 2);
    for (unsigned int i = 0; i < all.size(); ++i)
      {
        at_most(what + ": difference of ranks",
                std::abs(all[i] - alone[i]) / std::abs(all[i]),
                1e-9);
        at_most(what + ": difference of a cut body",
                std::abs(all[i] - cut[i]) / std::abs(all[i]),
                1e-9);
      }
  }

  void
  check_refusals()
  {
    const auto refused = [](const std::string              &method,
                            const std::string              &time,
                            const std::vector<std::string> &words) {
      test::check_throws_with(
        [&] {
          const auto parameters = parsed<2>(block<2>(method, time));
          Scene<2>(parameters, MPI_COMM_WORLD);
        },
        words);
    };
    refused("set Stress rule = trapezoidal\n",
            in_time,
            {"Method", "Locking treatment", "conserving"});
    refused("set Domain update = corners\n",
            in_time,
            {"Method", "Domain update", "corners"});
    refused("",
            "subsection Time\nset End time = 9\nset Step rule = fixed\n"
            "set Step size = 0.04\nset Integrator = explicit\nend\n",
            {"explicit", "Locking treatment"});
  }

  void
  check_absence()
  {
    std::string text = block<2>("", in_time);
    text.replace(text.find("= cell"), 6, "= none");
    const auto     parameters = parsed<2>(text);
    const Scene<2> scene(parameters, MPI_COMM_WORLD);
    check(!scene.layout.has(own_volume_field) &&
            !scene.layout.has("cell_mean_stress"),
          "no fields of a treatment that is not asked for");
  }

  /** What automatic is for elastic bodies: it leaves out fluids. */
  void
  check_choice()
  {
    const auto chosen = [](const std::string &constants) {
      std::string text = block<2>("", in_time);
      text.replace(text.find("= cell"), 6, "= automatic");
      const auto from = text.find("set Model"), to = text.find("end", from);
      text.replace(from,
                   to - from,
                   "set Model = Hencky\nset Density = 5\n" + constants);
      return parsed<2>(text).method.locking_treatment;
    };
    const auto nu = [](const std::string &value) {
      return "set Young's modulus = 100\nset Poisson's ratio = " + value + "\n";
    };
    const auto shear = [](const std::string &value) {
      return "set Bulk modulus = 2e9\nset Shear modulus = " + value + "\n";
    };
    check(chosen(nu("0.3")) == "none", "automatic: none for cork and steel");
    check(chosen(nu("0.45")) == "cell", "automatic: cell for rubber");
    check(chosen(nu("0.49999")) == "cell", "automatic: cell for gels");
    check(chosen(nu("0.4999999")) == "none", "automatic: none for fluids");
    check(chosen(shear("1e9")) == "none", "automatic: none, by moduli");
    check(chosen(shear("1e6")) == "cell", "automatic: cell, by moduli");
    check(chosen(shear("1e-6")) == "none", "automatic: none for water");
  }
  /** A block of metal and, far from it, one of cork, with a treatment. */
  std::string
  two_materials(const std::string &treatment)
  {
    std::string text = block<2>("set Geometry = middle\n", in_time);
    const auto  put  = [&text](const std::string &before,
                             const std::string &after) {
      text.replace(text.find(before), before.size(), after);
    };
    put("= cell", "= " + treatment);
    put("5, 5", "10, 5");
    put("0.04", "0.01");
    put("10, 10", "20, 10");
    put("set Names = m\n",
        "set Names = m, cork\nsubsection cork\nset Model = Hencky\n"
        "set Density = 5\nset Young's modulus = 100\n"
        "set Poisson's ratio = 0.3\nend\n");
    const auto        from = text.find("subsection block");
    const std::string body =
      text.substr(from, text.find("end\nend\n", from) + 8 - from);
    std::string second = body;
    second.replace(second.find("block"), 5, "other");
    second.replace(second.find("= m\n"), 4, "= cork\n");
    second.replace(second.find("= 1, 1"), 6, "= 6, 1");
    second.replace(second.find("= 3, 2.5"), 8, "= 8, 2.5");
    for (auto at = second.find("x - 2.1"); at != std::string::npos;
         at      = second.find("x - 2.1"))
      second.replace(at, 7, "x - 7.1");
    text.insert(from, second);
    put("set Names = block", "set Names = other, block");
    return text;
  }

  /** Metal flows and is treated, cork beside it is not. */
  void
  check_each_body()
  {
    // where the particles of each come to, each with its own weight
    const auto run = [](const std::string &treatment) {
      const auto            parameters = parsed<2>(two_materials(treatment));
      test::RunningScene<2> run(parameters, MPI_COMM_WORLD);
      run.advance(60);
      std::array<double, 2> result{};
      for (const auto &particle : run.scene.particles)
        {
          const auto &x = particle.get_location();
          result[x[0] > 5.] += (particle.get_id() % 7 + 1) * (x[0] + 2. * x[1]);
        }
      for (double &sum : result)
        sum = dealii::Utilities::MPI::sum(sum, MPI_COMM_WORLD);
      at_most("each body, " + treatment + ": balance",
              test::largest(run.column("balance_error")) /
                test::largest(run.column("kinetic_energy")),
              1e-12);
      check(parameters.method.locking_treatment == treatment,
            "the parameters of a run keep " + treatment);
      return result;
    };
    const auto none = run("none"), cell = run("cell"), each = run("automatic");
    at_most("each body: metal as with cell",
            std::abs(each[0] / cell[0] - 1.),
            1e-11);
    // the energy of a point alone is corrected otherwise than without
    // treatment: of the second order in the step
    const double as_none = std::abs(each[1] / none[1] - 1.),
                 as_cell = std::abs(cell[1] / none[1] - 1.);
    std::cout << "each body: cork differs by " << as_none << ", with cell by "
              << as_cell << '\n';
    at_most("each body: cork as with none", as_none / as_cell, 0.02);
    check(std::abs(cell[0] / none[0] - 1.) > 1e-6,
          "each body: the treatment makes a difference");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_tangent_of_start<2>("linear");
  check_tangent_of_start<2>("GIMP");
  check_tangent_of_start<3>("GIMP");
  check_tangent_of_middle<2>("linear", "stretch");
  for (const char *update : {"none", "detF", "diagF", "stretch"})
    check_tangent_of_middle<2>("GIMP", update);
  check_tangent_of_middle<3>("GIMP", "stretch");
  check_refusals();
  check_absence();
  check_choice();
  check_each_body();
  const std::string start  = "set Geometry = start\n",
                    middle = "set Geometry = middle\n";
  check_alike<2>(start, "2D, start");
  check_alike<2>(middle, "2D, middle");
  run_block<3>(middle, "3D, middle");
  return test::report();
}
