// Files, pictures and messages of a run: what is written, what is refused, and
// what is said. Runs on any number of ranks.

#include <emmy/base/whole_file.h>
#include <emmy/output/data_file.h>
#include <emmy/output/pictures.h>
#include <emmy/output/progress.h>
#include <emmy/output/run_directory.h>
#include <emmy/output/series.h>

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "../check.h"

namespace fs = std::filesystem;
using namespace emmy;
using dealii::Point;
using test::check;
using test::check_throws_with;

namespace
{
  const MPI_Comm world = MPI_COMM_WORLD;

  unsigned int
  rank()
  {
    return dealii::Utilities::MPI::this_mpi_process(world);
  }


  std::string
  contents(const fs::path &file)
  {
    std::ifstream      in(file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }


  std::size_t
  count(const std::string &text, const std::string &part)
  {
    std::size_t n = 0;
    for (auto at = text.find(part); at != std::string::npos;
         at      = text.find(part, at + 1))
      ++n;
    return n;
  }


  void
  check_contains(const fs::path &file, const std::vector<std::string> &parts)
  {
    const std::string text = contents(file);
    for (const std::string &part : parts)
      check(count(text, part) > 0, file.string() + " contains <" + part + ">");
  }


  // One of the largest that Debian's deal.II has; twice 2^31.
  constexpr double large_id = 4294967290.;


  // Rank 0 alone has particles and cells; the other ranks write empty pieces.
  template <int dim>
  void
  test_data_files(const std::string &folder)
  {
    const std::vector<FieldDescription> fields = {
      {"mass", 1, "kg", "of a particle"},
      {"velocity", dim, "m/s", "of a particle"},
      {"id", 1, "1", "of a particle", /*is_integer=*/true},
      {"stress", 9, "Pa", "Kirchhoff stress"}};
    const std::string points = "particles" + std::to_string(dim);
    const std::string cells  = "grid" + std::to_string(dim);
    Series            point_series(folder, points, world);
    Series            cell_series(folder, cells, world);

    for (unsigned int frame = 0; frame < 2; ++frame)
      {
        DataFile<0, dim> point_file(fields);
        check(point_file.n_values() == 2 + dim + 9,
              "a value for each component");
        DataFile<dim, dim>  cell_file({{"momentum", dim, "N s", "nodal"}});
        std::vector<double> values(point_file.n_values(), 0.5);
        const std::vector<double> nodal(cell_file.n_vertices * dim, 0.25);
        if (rank() == 0)
          {
            for (unsigned int i = 0; i < 5; ++i)
              {
                values[1 + dim] = large_id + i; // all the same as floats
                point_file.add_point(Point<dim>::unit_vector(0) * i, values);
              }
            auto vertices =
              std::array<Point<dim>, DataFile<dim, dim>::n_vertices>();
            for (unsigned int v = 0; v < vertices.size(); ++v)
              vertices[v] = dealii::GeometryInfo<dim>::unit_cell_vertex(v);
            cell_file.add_cell(vertices, nodal);
          }
        const double time = 0.5 * frame;
        point_series.add(time,
                         point_file.write(folder, points, frame, time, world));
        cell_series.add(time,
                        cell_file.write(folder, cells, frame, time, world));
      }

    if (rank() == 0)
      {
        const fs::path at(folder);
        check_contains(at / (points + "_0001.pvtu"),
                       {"\"mass\"",
                        "\"velocity\" NumberOfComponents=\"3\"",
                        "<PDataArray type=\"Int64\" Name=\"id\"",
                        "\"stress\" NumberOfComponents=\"9\"",
                        "units=\"m/s\""});
        const unsigned int n_ranks =
          dealii::Utilities::MPI::n_mpi_processes(world);
        check(count(contents(at / (points + "_0001.pvtu")), "<Piece ") ==
                n_ranks,
              "one piece for each rank");
        check(count(contents(at / (points + "_0000.0.vtu")),
                    "NumberOfPoints=\"5\"") == 1,
              "five particles");
        // behind the head of the points' data, each id as it is
        std::string piece = contents(at / (points + "_0000.0.vtu"));
        piece.erase(0, piece.find("<PointData"));
        check(count(piece.substr(0, piece.find("type=\"Float32\"")),
                    "<DataArray type=\"Int64\" Name=\"id\" format=\"ascii\">\n"
                    "4294967290 4294967291 4294967292 4294967293 4294967294 "
                    "\n    </DataArray>\n") == 1,
              "ids are whole numbers, without rounding");
        check(count(piece, "\"id\"") == 1, "ids are written once");
        check(count(contents(at / (cells + "_0000.0.vtu")),
                    "NumberOfCells=\"1\"") == 1,
              "one cell");
        if (n_ranks > 1)
          check(count(contents(at / (points + "_0000.1.vtu")),
                      "NumberOfPoints=\"0\"") == 1,
                "an empty piece");
        check_contains(at / (points + ".pvd"),
                       {"timestep=\"0.5\"", points + "_0000.pvtu"});
        check_contains(at / "fields.txt",
                       {"mass [kg]: of a particle",
                        "velocity [m/s] (vector)",
                        "stress [Pa] (tensor): Kirchhoff stress"});
        check(count(contents(at / "fields.txt"), points + ".pvd") == 1,
              "the fields are listed once");
      }

    using Fields = std::vector<FieldDescription>;
    check_throws_with(
      [] {
        DataFile<0, dim>(Fields{{"a", 5, "", ""}});
      },
      {"<a>", "5 components", "scalar"});
    check_throws_with(
      [] {
        DataFile<0, dim>(Fields{{"a", 1, "", ""}, {"a", 1, "", ""}});
      },
      {"<a>", "a name of its own"});
    check_throws_with(
      [&] {
        DataFile<0, dim> file({{"a", 1, "", ""}});
        file.write(folder + "/absent", "a", 0, 0., world);
      },
      {"absent/a_0000.0.vtu> cannot be written (No such file or directory)",
       "check that its folder exists",
       "the disk is not full"});
    check_throws_with(
      [&] { Series(folder + "/absent", "a", world).add(0, ""); },
      {"absent/a.pvd"});
  }


  // Half a file is never seen, nor left: not even one that is aside.
  void
  test_whole_file(const std::string &folder)
  {
    const fs::path file  = fs::path(folder) / "whole.txt";
    const fs::path aside = file.string() + ".new";
    check(write_whole_file(file.string(), "old\n").empty() &&
            contents(file) == "old\n",
          "a file is written");
    fs::create_symlink("/dev/full", aside); // as if the disk were
    check(write_whole_file(file.string(), std::string(100000, 'x')) ==
            "the file <" + file.string() +
              "> cannot be written (No space left on device)",
          "a full disk is told of");
    check(contents(file) == "old\n", "the old file is kept");
    check(!fs::exists(fs::symlink_status(aside)), "nothing stays aside");
    check(write_whole_file(file.string(), "new").empty() &&
            contents(file) == "new" && !fs::exists(aside),
          "a file is replaced");

    fs::create_directory(fs::path(folder) / "taken");
    check(count(write_whole_file(folder + "/taken", "x"),
                "taken> cannot be written") == 1,
          "a folder is not replaced");
    check(!fs::exists(folder + "/taken.new"), "nor does a file stay aside");
    check(count(write_whole_file(folder + "/absent/file", "x"),
                "absent/file> cannot be written (No such file") == 1,
          "a folder that is absent");
  }


  void
  test_run_directory(const std::string &folder)
  {
    const fs::path     run = fs::path(folder) / "new" / "run 1";
    const RunDirectory fresh(run.string(), false, world);
    check(fs::is_directory(run), "the folder is made, with its parents");
    check(fresh.file("ledger.csv") == (run / "ledger.csv").string(),
          "the name of a file");
    RunDirectory(run.string(), false, world); // empty: may be used again

    const std::vector<std::string> ours   = {"ledger.csv",
                                             "particles_0000.pvtu",
                                             "particles_0000.12.vtu",
                                             "particles.pvd",
                                             "grid_0003.1.vtu",
                                             "run.log",
                                             "timing.json",
                                             "timing.json.new",
                                             "parameters.prm",
                                             "fields.txt",
                                             "pictures/energies.png",
                                             "pictures/particles_00.dat"};
    const std::vector<std::string> theirs = {"notes.txt",
                                             "particles_of_mine.vtu",
                                             "pictures/particles_talk.png",
                                             "energies.png"};
    if (rank() == 0)
      {
        fs::create_directory(run / "pictures");
        for (const auto &names : {ours, theirs})
          for (const std::string &name : names)
            std::ofstream(run / name) << "x";
      }
    MPI_Barrier(world);

    check_throws_with([&] { RunDirectory(run.string(), false, world); },
                      {run.string(),
                       "--overwrite",
                       "set Overwrite = true",
                       "section Output",
                       "choose another directory"});
    check(fs::exists(run / "ledger.csv"), "a refused folder is left alone");
    MPI_Barrier(world);

    RunDirectory(run.string(), true, world);
    for (const std::string &name : ours)
      check(!fs::exists(run / name), name + " of the old run is removed");
    for (const std::string &name : theirs)
      check(fs::exists(run / name), name + " is not ours and is kept");

    check_throws_with(
      [&] { RunDirectory((run / "notes.txt/run").string(), true, world); },
      {"notes.txt/run", "cannot be created"});
    check_throws_with([&] { RunDirectory("/proc/emmy", true, world); },
                      {"/proc/emmy", "check the spelling"});
    check_throws_with([&] { RunDirectory("/proc/self", true, world); },
                      {"/proc/self", "no file can be written"});
    check_throws_with([&] { RunDirectory("", true, world); },
                      {"no folder is given"});
  }


  void
  test_progress()
  {
    // 97 of 100 equal steps: three first ones, 5 % ... 95 %, and the last.
    std::ostringstream screen, log;
    {
      Progress progress(screen, false, log, 10., 0);
      for (unsigned int step = 1; step <= 97; ++step)
        {
          progress.step(step, 0.1 * step, 0.1, 3, 1.2e-15);
          if (step == 50)
            progress.note("a note");
        }
      progress.finish();
      progress.finish();
    }
    check(count(log.str(), "\n") == 97 + 1, "each step and note is logged");
    check(count(screen.str(), "\n") == 3 + 19 + 1 + 1,
          "a line at the first steps, every 5 %, a note and the last step");
    check(count(screen.str(),
                "step 97  t 9.7 s  dt 0.1 s  Newton 3  "
                "balance 1.2e-15  97 %  left 0:00\n") == 1,
          "the last step");
    check(count(screen.str(), "\033") + count(screen.str(), "\r") == 0,
          "no control characters in a file");

    // The limit on steps counts if it ends the run sooner.
    std::ostringstream terminal, unused;
    std::ostringstream slow_screen, slow_terminal;
    {
      Progress patient(slow_screen, false, unused, 10., 0, /*patience=*/1e3);
      patient.working("Step 1: Newton iteration 1");
      check(slow_screen.str().empty(), "no news before patience ends");
      Progress impatient(slow_screen, false, unused, 10., 0, 0.);
      impatient.working("Step 1: Newton iteration 2");
      check(slow_screen.str() == "Step 1: Newton iteration 2 (0:00)\n",
            "then a line of news");
      Progress in_place(slow_terminal, true, unused, 10., 0, 0.);
      in_place.working("Step 1: Newton iteration 3");
      check(count(slow_terminal.str(), "iteration 3 (0:00)") == 1 &&
              count(slow_terminal.str(), "\n") == 0,
            "on a terminal in place");
    }
    Progress short_run(terminal, true, unused, 10., 4);
    short_run.step(1, 0.1, 0.1, 2, 0.);
    check(count(terminal.str(), "25 %") == 1, "one of four steps is 25 %");
    check(count(terminal.str(), "\n") == 0, "the line is drawn in place");
    for (unsigned int step = 2; step <= 4; ++step)
      short_run.step(step, 0.1 * step, 0.1, 2, 0.);
    check(count(terminal.str(), "step") <= 2, "at most ten times a second");
    short_run.finish();
    check(count(terminal.str(), "100 %") == 1 &&
            count(terminal.str(), "\n") == 1,
          "the last line stays");
  }


  bool
  gnuplot_is_installed()
  {
    const char        *path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');)
      if (fs::exists(fs::path(folder) / "gnuplot"))
        return true;
    return false;
  }


  template <int dim>
  void
  test_pictures(const std::string &folder)
  {
    // A name that a careless shell would trip over.
    const fs::path run =
      fs::path(folder) / ("it's a \"$(run)\" " + std::to_string(dim));
    fs::create_directory(run);
    std::ofstream ledger(run / "ledger.csv");
    ledger << "step,time,kinetic_energy,strain_energy,contact_energy,load_work,"
              "tool_plate_work,residual_work,balance_error,tool_plate_x,"
              "tool_plate_y,tool_plate_force_x,tool_plate_force_y\n";
    for (unsigned int i = 0; i < 20; ++i)
      ledger << i << "," << 0.1 * i << "," << 20 - i << "," << i << ",0,0,0,0,"
             << (i % 5) * 1e-15 << ",0," << -0.1 * i << ",0," << i << "\n";
    ledger.close();

    Pictures                  pictures(run.string(), "Someone's title_1");
    std::vector<Point<dim>>   positions;
    std::vector<double>       energies;
    std::vector<unsigned int> n_cells(dim, 4);
    Point<dim>                lower, upper;
    for (unsigned int d = 0; d < dim; ++d)
      upper[d] = 4.;
    for (unsigned int i = 0; i < 200; ++i)
      {
        Point<dim> position;
        for (unsigned int d = 0; d < dim; ++d)
          position[d] = 1. + 0.2 * (d == 0 ? i % 10 : i / 10 % 10);
        positions.push_back(position);
        energies.push_back(i);
      }
    pictures.add_snapshot(0., {}, {}, lower, upper, n_cells); // no particles
    pictures.add_snapshot(1., positions, energies, lower, upper, n_cells);
    check(count(contents(run / "pictures/particles_01.dat"), "\n") == 201,
          "the points of a snapshot");
    Surface<dim> surface;
    surface.facets.resize(3);
    pictures.add_surfaces<dim>({surface});
    check(count(contents(run / "pictures/surfaces_01.dat"), "\n") ==
            3 * (dim + 1),
          "the facets of a surface");
    Pictures later(run.string(), "");
    later.recall(pictures.memory());
    check(later.memory() == pictures.memory() && later.memory().back() == 1.,
          "snapshots are remembered, with their surfaces");

    const auto warnings = pictures.draw("strain energy (J)");
    for (const std::string name :
         {"energies", "balance_error", "forces_plate", "particles"})
      {
        const fs::path picture = run / "pictures" / name;
        check(fs::exists(picture.string() + ".gp"), name + ".gp is written");
        std::error_code absent;
        const auto      size = fs::file_size(picture.string() + ".png", absent);
        if (gnuplot_is_installed())
          check(!absent && size > 5000, name + ".png is drawn");
      }
    const std::string colours = contents(run / "pictures/particles.gp");
    check(count(colours, "first = 2\nlast  = 197\n") == 1,
          "colours from the 1st to the 99th percentile of 0, 1, ..., 199");
    check(count(colours, "strain energy (J), from 0 to 199") == 1,
          "the extremes are in the legend");
    check(count(contents(run / "pictures/particles.gp"), "'surfaces_01.dat'") ==
            1,
          "a surface is shown in its snapshot");
    const std::string script = contents(run / "pictures/energies.gp");
    check(count(script, "+ column('contact_energy')") > 0,
          "what contact stores is in the total");
    check(count(script, "column('load_work') + column('tool_plate_work')") >
              0 &&
            count(script, "residual_work") == 0,
          "all works from outside, and not what solves left");
    for (const std::string &warning : warnings)
      check(!gnuplot_is_installed(), "unexpected warning: " + warning);
    if (gnuplot_is_installed())
      check(contents(run / "pictures/gnuplot.log").empty(),
            "gnuplot does not complain:\n" +
              contents(run / "pictures/gnuplot.log"));
  }


  // Nothing is thrown, whatever lacks: gnuplot, the ledger, the folder.
  void
  test_pictures_that_cannot_be_drawn(const std::string &folder)
  {
    const std::string path = std::getenv("PATH") ? std::getenv("PATH") : "";
    setenv("PATH", (folder + "/no programs here").c_str(), 1);
    Pictures without_gnuplot(folder, "");
    without_gnuplot.add_snapshot<2>(
      0., {Point<2>(0.5, 0.5)}, {1.}, {0., 0.}, {1., 1.}, {2, 2});
    const auto warnings = without_gnuplot.draw("energy");
    setenv("PATH", path.c_str(), 1);
    check(warnings.size() == 2 && count(warnings[0], "no ledger.csv") == 1,
          "a missing ledger is a warning");
    check(warnings.size() == 2 &&
            count(warnings[1], "gnuplot is not installed") == 1 &&
            count(warnings[1], "pictures") > 0,
          "missing gnuplot is a warning that says where the scripts are");

    Pictures without_folder("/proc/absent", "");
    without_folder.add_snapshot<2>(
      0., {Point<2>(0.5, 0.5)}, {1.}, {0., 0.}, {1., 1.}, {2, 2});
    check(without_folder.draw("energy").size() >= 2,
          "a missing folder is a warning");
  }
} // namespace


int
main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  dealii::deal_II_exceptions::disable_abort_on_exception();
  setenv("LC_ALL", "C", 1); // pictures are right in any locale

  const unsigned int n_ranks = dealii::Utilities::MPI::n_mpi_processes(world);
  const std::string  folder =
    (fs::temp_directory_path() /
     ("emmy_output_test_" + std::to_string(n_ranks) + "_" +
      std::to_string(dealii::Utilities::MPI::broadcast(world, getpid(), 0))))
      .string();
  const RunDirectory scratch(folder, false, world);

  test_data_files<2>(folder);
  test_data_files<3>(folder);
  test_run_directory(folder);
  if (rank() == 0)
    {
      test_whole_file(folder);
      test_progress();
      test_pictures<2>(folder);
      test_pictures<3>(folder);
      test_pictures_that_cannot_be_drawn(folder);
    }

  MPI_Barrier(world);
  if (rank() == 0)
    fs::remove_all(folder);
  return test::report();
}
