// The detector of motion and matter that the grid does not see: when it speaks,
// what it advises, that bodies which fly, rest or collide do not wake it, what
// the columns are in closed form, and that they do not depend on the ranks.

#include <emmy/step/detector.h>

#include "../scene.h"

using namespace emmy;
using test::check;
using test::check_close;

namespace
{
  constexpr RemediesInUse none{false, false, false, false},
    all{true, true, true, false}, all_but_middle{true, false, true, false};

  /** Steps that look alike: kinetic and stored energy, hidden, overfill. */
  struct Steps
  {
    double kinetic, stored, hidden, overfill;
  };

  /** The notes of a run of such steps, and its last row. */
  std::pair<std::vector<std::string>, std::vector<StepMeasure>>
  run(const RemediesInUse                               &in_use,
      const std::vector<std::pair<unsigned int, Steps>> &parts,
      const double                                       overfill_at_start = 0.)
  {
    DetectorState state;
    Told          told;
    Detector      detector(in_use, state, told);
    StepReport    initial;
    detector.begin(overfill_at_start, initial);
    check(initial.measures.size() == 3, "row 0 has the three columns");
    std::vector<std::string> notes;
    StepReport               report;
    double                   stored = 0.;
    for (const auto &[n, step] : parts)
      for (unsigned int i = 0; i < n; ++i)
        {
          report                       = StepReport();
          report.totals.kinetic_energy = step.kinetic;
          report.energies              = {
                         {"strain_energy", EnergyEntry::Kind::stored, step.stored - stored}};
          stored = step.stored;
          detector.look(step.hidden, step.overfill, "Step", report);
          notes.insert(notes.end(), report.notes.begin(), report.notes.end());
        }
    return {notes, report.measures};
  }

  unsigned int
  n_notes(const std::vector<std::pair<unsigned int, Steps>> &parts,
          const double overfill_at_start = 0.)
  {
    return run(all, parts, overfill_at_start).first.size();
  }

  void
  check_rule()
  {
    const Steps quiet{1., 1., 1e-5, 1e-4}, noisy{1., 1., 0.01, 0.05};
    check(n_notes({{100, quiet}}) == 0, "a quiet run: no note");
    check(n_notes({{1, quiet}, {9, noisy}, {1, quiet}, {9, noisy}}) == 0,
          "not for long: no note");
    check(n_notes({{1, quiet}, {10, noisy}}) == 1, "ten steps on end: a note");
    check(n_notes({{1, quiet}, {50, noisy}, {1, quiet}, {50, noisy}}) == 1,
          "one note in a run");
    check(n_notes({{100, {1., 1., 0.01, 0.}}}) == 0, "no overfill: no note");
    check(n_notes({{100, {1., 1., 0., 0.05}}}) == 0, "not hidden: no note");
    check(n_notes({{100, {1., 0.1, 0.01, 0.05}}}) == 0,
          "an impact, little is stored: no note");
    check(n_notes({{100, noisy}}, 0.04) == 0,
          "a lattice that overfills nodes from the start: no note");
    check(n_notes({{100, {1., 0., 0.3, 0.}}}) == 1,
          "a third of the motion is hidden: a note");
    check(n_notes({{100, {1., 0., 0., 0.6}}}) == 1,
          "a node holds 1.6 of its place: a note");
    check(n_notes({{1, {1., 1., 0., 0.}}, {100, {1e-9, 1., 1e-9, 0.05}}}) == 0,
          "a body that comes to rest: no note");
    check(n_notes({{100, {1e-12, 1., 1e-13, 0.05}}}) == 0,
          "next to nothing moves: no note");
    check(n_notes({{100, {0., 0., 0., -1.}}}) == 0, "at rest: no note");
  }

  void
  check_words()
  {
    const std::vector<std::pair<unsigned int, Steps>> noise{
      {20, {2., 2., 0.01, 0.05}}};
    const auto says = [&](const RemediesInUse &in_use,
                          const std::string   &words) {
      const auto notes = run(in_use, noise).first;
      check(notes.size() == 1 && notes[0].find(words) != std::string::npos,
            "the note says: " + words +
              (notes.empty() ? "" : "; but it is: " + notes[0]));
    };
    says(all_but_middle, "Remedy: Method/Geometry = middle");
    says(none,
         "Remedy: Method/Shape functions = GIMP and Method/Geometry = middle "
         "and Method/Starved nodes = follow");
    says(all, "Remedy: more Points per direction, or Method/Mapping = blend");
    says({true, true, true, true}, "Remedy: more Points per direction");
    says(all,
         "Step: particles have 0.01 J, 0.5 % of the largest kinetic energy, in "
         "motion that the grid does not see, and a node holds 5 % more than "
         "its place. Results can be wrong while all balances hold.");
    const auto row = run(all, noise).second;
    check(row.size() == 3 && row[0].name == "hidden_kinetic_energy" &&
            row[1].name == "hidden_share" && row[2].name == "overfill",
          "names of the columns");
    check_close(row[0].value, 0.01, 0., "hidden kinetic energy, J");
    check_close(row[1].value, 0.005, 1e-15, "share of the largest so far");
    check_close(row[2].value, 0.05, 0., "overfill");
  }

  /** A block of 2 x 2 cells; settings by "Section/Entry=value". */
  ParameterFile
  block(const std::vector<std::string> &settings)
  {
    ParameterFile file = ParameterFile::from_text(
      "set Dimension = 2\nsubsection Grid\n"
      "set Lower corner = 0, 0\nset Upper corner = 4, 4\nset Cells = 4, 4\n"
      "end\nsubsection Materials\nset Names = m\nsubsection m\n"
      "set Model = Hencky\nset Density = 3\nset Young's modulus = 100\n"
      "set Poisson's ratio = 0.3\nend\nend\n"
      "subsection Bodies\nset Names = b\nsubsection b\n"
      "set Shape = box\nset Material = m\nset Points per direction = 2\n"
      "subsection box\nset Lower corner = 0, 0\nset Upper corner = 2, 2\n"
      "end\nend\nend\n"
      "subsection Time\nset Step rule = fixed\nset Step size = 1e-3\n"
      "set End time = 1\nend\n",
      "block");
    for (const std::string &setting : settings)
      file.set(setting);
    return file;
  }

  /**
   * A body that tiles its cells overfills no node, also at a side of the grid.
   * Of a checkerboard of velocities, +-1 m/s, the grid sees next to nothing: in
   * each direction the points' values (1, -1, 1, -1) have 1/5 of their square
   * in the span of the linear functions, so 1 - 1/25 is hidden; nodal means
   * give them (3, 1, -1, -3)/8, so that 1 - (2 (1/2)^2 - (5/16)^2)/16 is left.
   * Boxes of GIMP that touch faces of cells have the same values. A linear
   * field is not hidden.
   */
  void
  check_closed_forms()
  {
    const std::string velocity = "Bodies/b/Initial velocity=";
    for (const std::string shape : {"linear", "GIMP"})
      for (const std::string integrator : {"implicit", "explicit"})
        {
          std::vector<std::string> settings{"Method/Shape functions=" + shape,
                                            "Method/Starved nodes=free",
                                            "Method/Geometry=start",
                                            "Time/Integrator=" + integrator};
          const std::string        name = shape + ", " + integrator + ": ";
          settings.push_back(velocity + "sin(2*pi*x)*sin(2*pi*y); 0");
          const SceneParameters<2> with_board(block(settings));
          test::RunningScene<2>    hidden(with_board);
          hidden.advance(1);
          settings.back() = velocity + "1 + 0.5*x - y; 0.3*x";
          const SceneParameters<2> with_line(block(settings));
          test::RunningScene<2>    seen(with_line);
          seen.advance(1);

          const double K    = 0.5 * 3. * 4.; // 3 kg/m^2, 4 m^2, 1 m/s
          const double part = integrator == "implicit"
                                ? 24. / 25.
                                : 1. - (0.5 - 25. / 256.) / 16.;
          check_close(hidden.ledger["hidden_kinetic_energy"],
                      part * K,
                      1e-6 * K,
                      name + "of a checkerboard is hidden, J");
          check_close(hidden.ledger["hidden_share"],
                      part,
                      1e-6,
                      name + "share of a checkerboard that is hidden");
          if (integrator == "implicit")
            check_close(seen.ledger["hidden_kinetic_energy"],
                        0.,
                        (shape == "linear" ? 1e-13 : 1e-6) *
                          seen.column("kinetic_energy")[0],
                        name + "a linear field is not hidden, J");
          for (const double overfill : hidden.column("overfill"))
            check_close(overfill,
                        0.,
                        1e-6,
                        name + "overfill of a body that tiles its cells");
        }
  }

  /** On all ranks the same; and no note. */
  void
  check_ranks()
  {
    const std::vector<std::string> columns{"kinetic_energy",
                                           "hidden_kinetic_energy",
                                           "hidden_share",
                                           "overfill"};
    // free nodes that few particles reach would magnify round-off
    for (const std::vector<std::string> &settings :
         std::vector<std::vector<std::string>>{
           {"Method/Starved nodes=follow", "Method/Geometry=middle"},
           {"Method/Starved nodes=follow", "Method/Lumping=0.2"},
           {"Method/Starved nodes=follow", "Method/Mapping=PIC"},
           {"Time/Integrator=explicit"}})
      {
        ParameterFile file =
          ParameterFile::from_text(test::collision_text(2, "GIMP"), "discs");
        for (const std::string &setting : settings)
          file.set(setting);
        test::compare_ranks<2>(file, 15, "discs, " + settings.back(), columns);
      }
  }

  /** Balls that collide: nothing to say. */
  void
  check_two_balls(const std::string &path)
  {
    const SceneParameters<3> parameters{ParameterFile(path)};
    test::RunningScene<3>    run(parameters);
    run.advance_to(parameters.time.end_time * (1. - 1e-12));
    std::cout << "two balls: hidden share at most "
              << test::largest(run.column("hidden_share")) << '\n';
    check(test::largest(run.column("hidden_share")) > 1e-4,
          "two balls: some motion is hidden");
    check(test::n_warnings(run.notes) == 0, "two balls: no warning");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_ranks();
  if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) == 1)
    {
      check_rule();
      check_words();
      check_closed_forms();
      check_two_balls(argv[1]);
    }
  return test::report();
}
