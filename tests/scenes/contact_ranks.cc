// Bodies that meet and rub give the same ledger on one rank and on several,
// also where starved nodes follow, in the plane and in space.

#include "../check.h"
#include "../scene.h"

using namespace emmy;

namespace
{
  template <int dim>
  std::string
  text(const std::string &geometry)
  {
    const auto in = [](const std::string &plane, const std::string &space) {
      return dim == 2 ? plane : space;
    };
    // they meet along a line or a plane that ranks cut, wherever they do
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Grid\nset Lower corner = " + in("0, 0", "0, 0, 0") +
           "\nset Upper corner = " + in("6, 4", "5, 3, 3") +
           "\nset Cells = " + in("24, 16", "10, 6, 6") +
           "\nend\nsubsection Method\nset Geometry = " + geometry +
           "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 100\nset Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = left, right\n"
           "subsection left\nset Shape = box\nset Material = m\n"
           "set Points per direction = 2\nset Initial velocity = " +
           in("0.3 + 0.1*y; 1", "0.3; 1; 0.1*y") +
           "\nsubsection box\nset Lower corner = " + in("1, 1", "1, 0.8, 0.8") +
           "\nset Upper corner = " + in("5, 1.9", "4, 1.4, 2.2") +
           "\nend\nend\n"
           "subsection right\nset Shape = box\nset Material = m\n"
           "set Points per direction = 3\nset Initial velocity = " +
           in("-0.3; -1 + 0.1*x", "-0.3; -1; 0") +
           "\nsubsection box\nset Lower corner = " +
           in("1.2, 2.1", "1.2, 1.6, 1") +
           "\nset Upper corner = " + in("4.8, 2.9", "3.8, 2.1, 2") +
           "\nend\nend\nend\n"
           "subsection Effects\nset Names = contact\nsubsection Contact\n"
           "set Groups = left | right\nset Friction coefficient = 0.3\n"
           "end\nend\nsubsection Time\nset End time = 2\n"
           "set Step rule = fixed\nset Step size = 0.04\nend\n"
           "subsection Ranks\nset Rebalance above = 1.05\nend\n"
           "subsection Solver\nset Newton tolerance = 1e-15\nend\n";
  }

  template <int dim>
  void
  check_ranks(const std::string &geometry, const unsigned int n_steps)
  {
    const std::string name =
      std::to_string(dim) + "D, geometry of the " + geometry;
    test::compare_ranks<dim>(ParameterFile::from_text(text<dim>(geometry),
                                                      name),
                             n_steps,
                             name,
                             {"kinetic_energy",
                              "strain_energy",
                              "contact_energy",
                              "friction_energy",
                              "friction_dissipation",
                              "contact_left_force_x",
                              "contact_pairs",
                              "linear_momentum_x",
                              "angular_momentum_z",
                              "active_dofs"});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const char *geometry : {"start", "middle"})
    {
      check_ranks<2>(geometry, 10);
      check_ranks<3>(geometry, 4);
    }
  return test::report();
}
