// The sizes of steps that the rules give, against the numbers of the paper
// (Pretti et al. 2023, table 3 with its misprint corrected, table 4) and
// against each other.

#include "../check.h"
#include "../scene.h"

using namespace emmy;

namespace
{
  double
  first_step(ParameterFile file, const std::vector<std::string> &assignments)
  {
    for (const std::string &assignment : assignments)
      file.set(assignment);
    const SceneParameters<2> parameters(file);
    Scene<2>                 scene(parameters, MPI_COMM_WORLD);
    return scene.stepper->initial_report().time_step;
  }

  /** The beam of section 7.1, with the steps of eq. 57. */
  double
  beam(const std::string &young_modulus, const std::string &poisson_ratio)
  {
    return first_step(
      ParameterFile::from_text(
        "set Dimension = 2\n"
        "subsection Method\nset Shape functions = linear\n"
        "set Starved nodes = free\nend\n"
        "subsection Grid\nset Upper corner = 11, 20\nset Cells = 22, 40\nend\n"
        "subsection Materials\nset Names = m\nsubsection m\n"
        "set Model = Hencky\nset Density = 7750000\n"
        "set Young's modulus = " +
          young_modulus + "\nset Poisson's ratio = " + poisson_ratio +
          "\nend\nend\n"
          "subsection Bodies\nset Names = beam\nsubsection beam\n"
          "set Shape = box\nset Material = m\nset Points per direction = 2\n"
          "subsection box\nset Lower corner = 0, 9.5\n"
          "set Upper corner = 10, 10.5\nend\nend\nend\n"
          "subsection Time\nset End time = 150\nset Step rule = wave\n"
          "set Factor = 15\nend\n",
        "beam"),
      {});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);

  test::check_close(beam("1e9", "0.2"), 0.6264, 5e-5, "7.1 A, wave, s");
  test::check_close(beam("3e8", "0.49"), 0.2914, 5e-5, "7.1 B, wave, s");

  const ParameterFile cylinders(argv[1]);
  test::check_close(first_step(cylinders, {}),
                    0.0573,
                    5e-5,
                    "7.2, paper (eq. 61 as printed), s");
  const std::string no_limit = "Time/Maximum travel=0";
  const double wave = first_step(cylinders, {"Time/Step rule=wave", no_limit});
  test::check_close(wave, 1.927, 5e-4, "7.2, wave, s");
  // the cylinders are 4.4 m apart, close at 1.5 m/s, and may come to two cells
  // of 2 m between the middles of what lies in them
  const double way = 1.5 * first_step(cylinders, {"Time/Step rule=wave"});
  test::check(way < 4.4 - 1. && way > 4.4 - 2. * 2.,
              "7.2, wave, they come near, and do not meet within a step");
  test::check_close(first_step(cylinders,
                               {"Time/Step rule=normalised", no_limit}),
                    wave,
                    1e-12,
                    "7.2, normalised = wave for an undeformed material, s");
  test::check_close(
    first_step(cylinders, {"Time/Step rule=fixed", "Time/Step size=0.125"}),
    0.125,
    0.,
    "fixed, s");
  // the nodal sums of eq. 61 grow with the points: its step shrinks as their
  // square root does
  test::check_close(first_step(cylinders,
                               {"Bodies/left/Points per direction=70",
                                "Bodies/right/Points per direction=70"}) *
                      2.,
                    first_step(cylinders, {}),
                    2e-4,
                    "7.2, paper, twice the points per direction, s");
  return test::report();
}
