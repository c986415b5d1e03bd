// A parameter file is read as deal.II reads it, and every mistake in it is
// reported with file, line and the nearest valid name.

#include <emmy/base/declared_parameters.h>
#include <emmy/base/formula.h>
#include <emmy/base/parameter_file.h>

#include <deal.II/base/parameter_handler.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "../check.h"

using namespace emmy;
using namespace emmy::test;
using dealii::ParameterHandler;
namespace Patterns = dealii::Patterns;

namespace
{
  ParameterFile
  text(const std::string &content)
  {
    return ParameterFile::from_text(content, "a.prm");
  }

  // What the scenes below may contain.
  struct Scene
  {
    double              density = 0.;
    std::vector<double> corner  = {0., 0.};
    ParameterHandler    prm;

    Scene()
    {
      prm.declare_entry("Dimension", "2", Patterns::Integer(2, 3), "2 or 3.");
      prm.declare_entry("Title", "none");
      prm.enter_subsection("Materials");
      prm.declare_entry("Names", "", Patterns::List(Patterns::Anything()));
      prm.enter_subsection("rubber 7.1");
      prm.add_parameter("Density",
                        density,
                        "Mass per volume. Unit: kg/m^3.",
                        Patterns::Double(0.));
      prm.declare_entry("Young's modulus", "0", Patterns::Double());
      prm.declare_entry("Model",
                        "Hencky",
                        Patterns::Selection("Hencky|von Mises"));
      prm.leave_subsection();
      prm.leave_subsection();
      prm.enter_subsection("Grid");
      prm.add_parameter("Lower corner",
                        corner,
                        "Unit: m.",
                        Patterns::List(Patterns::Double(), 2, 3));
      prm.declare_entry("Force", "0; 0");
      prm.declare_entry("Periodic", "false", Patterns::Bool());
      prm.declare_entry("Old force", "0", Patterns::Integer());
      prm.declare_alias("Old force", "Older force");
      prm.leave_subsection();
      prm.enter_subsection("Time");
      prm.declare_entry("End time", "1", Patterns::Double(0.));
      prm.add_action("End time", [](const std::string &value) {
        AssertThrow(value != "13", dealii::ExcMessage("thirteen is unlucky"));
        if (value == "14")
          throw std::invalid_argument("fourteen too");
      });
      prm.enter_subsection("Nothing");
      prm.leave_subsection();
      prm.leave_subsection();
    }

    std::string
    get(const std::vector<std::string> &section, const std::string &name)
    {
      return prm.get(section, name);
    }
  };

  void
  parse(const std::string &content)
  {
    Scene scene;
    text(content).parse(scene.prm);
  }

  void
  test_syntax()
  {
    const ParameterFile file = text("\xef\xbb\xbf# a comment\r\n"
                                    "\r\n"
                                    "set Title = a = b; c, d # the rest\r\n"
                                    "SET\tDimension\t=3\r\n"
                                    "subsection Materials # of the scene\n"
                                    "  SUBSECTION rubber 7.1\n"
                                    "    set Young's modulus = 1e5\n"
                                    "  END # rubber\n"
                                    "  set Names = rubber, \\\n"
                                    "              steel, \\  \n"
                                    "              wood\n"
                                    "end\n"
                                    "subsection  Grid\n"
                                    "  set Force =\n"
                                    "end\n"
                                    "subsection Time\n"
                                    "end\n"
                                    "# swallows the next line \\\n"
                                    "set Nonsense = 1\n"
                                    "subsection Grid\n"
                                    "  set Periodic = true#\\\n"
                                    "end of comment\n"
                                    "end\\");

    check(file.value("Title", "") == "a = b; c, d", "a comment after a value");
    check(file.value("Dimension", "") == "3", "upper case and tabs");
    check(file.value("Materials/rubber 7.1/Young's modulus", "") == "1e5",
          "nested sections");
    check(file.value("Materials/Names", "") == "rubber, steel, wood",
          "continued lines");
    check(file.value("Grid/Force", "none").empty(),
          "an empty value is a value");
    check(file.value("Grid/Forces", "none") == "none", "the default value");
    check(file.value("Materials/rubber 7.1", "none") == "none",
          "a section has no value");
    check(file.has_section("Time") && file.has_section("Materials/rubber 7.1"),
          "sections that are there");
    check(!file.has_section("Tim") && !file.has_section("Title") &&
            !file.has_section(""),
          "sections that are not there");
    check(!ParameterFile().has_section("Time"), "an empty file has no section");

    Scene scene;
    file.parse(scene.prm);
    check(scene.get({}, "Title") == "a = b; c, d", "a value with ; , and =");
    check(scene.get({"Materials"}, "Names") == "rubber, steel, wood", "names");
    check(scene.get({"Materials", "rubber 7.1"}, "Young's modulus") == "1e5",
          "names with an apostrophe and a point");
    check(scene.get({"Grid"}, "Force").empty(), "an empty value arrives");
    check(scene.prm.get_bool({"Grid"}, "Periodic"), "joined, then commented");
    check(scene.get({"Time"}, "End time") == "1", "defaults stay");

    // deal.II itself reads the same
    Scene reference;
    reference.prm.parse_input_from_string(
      "set Title = a # b\nset Dimension = \\\n3 # c\n# \\\nset Nonsense = 1\n");
    Scene ours;
    text(
      "set Title = a # b\nset Dimension = \\\n3 # c\n# \\\nset Nonsense = 1\n")
      .parse(ours.prm);
    check(ours.prm == reference.prm, "the same parameters as deal.II's own");

    // what a run writes beside its results can be read again
    std::ostringstream written;
    scene.prm.print_parameters(written, ParameterHandler::PRM);
    Scene again;
    text(written.str()).parse(again.prm);
    check(again.prm == scene.prm, "print_parameters() and back");
  }

  void
  test_syntax_errors()
  {
    check_throws_with([] { text("\nsubsction Grid\n"); },
                      {"a.prm, line 2:",
                       "cannot understand <subsction Grid>",
                       "did you mean <subsection>?"});
    check_throws_with([] { text("Dimension = 2"); },
                      {"a.prm, line 1:", "cannot understand", "set NAME ="});
    for (const std::string line : {"Set A = 2",
                                   "set A",
                                   "set = 2",
                                   "set",
                                   "subsection",
                                   "endx",
                                   "end of Grid",
                                   "include",
                                   "set A\\\nB"})
      check_throws_with([&] { text("subsection Grid\n" + line + "\nend\n"); },
                        {"a.prm, line 2: cannot understand <" +
                         line.substr(0, 5)});

    check_throws_with([] { text("end"); },
                      {"a.prm, line 1:", "<end> closes no section"});
    check_throws_with(
      [] { text("\nsubsection A\nsubsection B\nend\nset C = 1"); },
      {"a.prm, line 2:", "section <A> is not closed", "<end>"});
    check_throws_with(
      [] {
        text("subsection Grid\nset Force = 1 \\\n; 2\nend\n"
             "subsection Grid\nset Force = 1; 2\nend\n");
      },
      {"a.prm, line 6: <Grid/Force> is given a second time", "a.prm, line 2"});
    check_throws_with([] { ParameterFile("no/such.prm"); },
                      {"cannot read the file <no/such.prm>"});
    check_throws_with([] { ParameterFile("/"); }, {"cannot read the file </>"});
  }

  void
  test_includes()
  {
    namespace fs = std::filesystem;
    const fs::path directory =
      fs::temp_directory_path() /
      ("emmy_parameter_file_" + std::to_string(getpid()));
    fs::create_directories(directory / "parts");
    const auto write = [&](const std::string &name,
                           const std::string &content) {
      std::ofstream(directory / name) << content;
      return (directory / name).string();
    };

    write("parts/density.prm", "set Density = 3\n");
    write("parts/rubber.prm",
          "subsection rubber 7.1\n  include density.prm # beside this\nend\n");
    const std::string main = write("main.prm",
                                   "subsection Materials\n"
                                   "  include parts/rubber.prm\n"
                                   "  subsection rubber 7.1\n"
                                   "    set Density = 4\n"
                                   "  end\n"
                                   "end\n");
    Scene             scene;
    ParameterFile(main).parse(scene.prm);
    check_close(scene.density, 4., 0., "a file overrides what it includes");

    write("parts/density.prm", "set Density = 3\nset Densty = 3\n");
    check_throws_with([&] { ParameterFile(main).parse(scene.prm); },
                      {"density.prm, line 2: unknown parameter "
                       "<Materials/rubber 7.1/Densty>"});

    write("parts/density.prm", "end\n");
    check_throws_with([&] { ParameterFile{main}; },
                      {"density.prm, line 1: this <end> closes no section"});
    write("parts/density.prm", "subsection A\n");
    check_throws_with([&] { ParameterFile{main}; },
                      {"density.prm, line 1: section",
                       "A> is not closed before the end of the file"});

    write("parts/density.prm", "\ninclude ../parts/rubber.prm\n");
    check_throws_with([&] { ParameterFile{main}; },
                      {"density.prm, line 2:",
                       "would include itself",
                       "main.prm ->",
                       "density.prm ->"});
    fs::remove(directory / "parts/density.prm");
    check_throws_with([&] { ParameterFile{main}; },
                      {"rubber.prm, line 2: cannot read the file <",
                       "parts/density.prm>",
                       "relative to the including file"});
    fs::remove_all(directory);
  }

  void
  test_set()
  {
    Scene         scene;
    ParameterFile file = text("subsection Time\nset End time = 2\nend\n"
                              "set Dimension = 3\n");
    file.set("Time/End time=5");
    file.set(" Time / End time = 7 ");
    file.set("Title=a=b; c");
    file.set("Materials/rubber 7.1/Density=2");
    file.set("Grid/Force=");
    check(file.value("Time/End time", "") == "7", "the last one wins");
    check(file.has_section("Materials/rubber 7.1"), "set() opens sections");
    file.parse(scene.prm);
    check(scene.get({"Time"}, "End time") == "7", "set() overrides the file");
    check(scene.get({}, "Title") == "a=b; c", "only the first = separates");
    check(scene.get({"Grid"}, "Force").empty(), "set() to nothing");
    check_close(scene.density, 2., 0., "the variable behind the entry");

    for (const std::string bad : {"Title",
                                  "=2",
                                  "",
                                  "Time/=2",
                                  "/Title=2",
                                  "Time//End time=2",
                                  "Title=a # b"})
      check_throws_with([&] { file.set(bad); },
                        {"--set: cannot understand <" + bad + ">",
                         "Section/Subsection/Name=value"});

    file.set("Time/End tme=2");
    file.set("Tme/End time=2");
    check_throws_with([&] { file.parse(scene.prm); },
                      {"--set: unknown parameter <Time/End tme>",
                       "did you mean <End time>?",
                       "--set: unknown section <Tme>",
                       "did you mean <Time>?"});
  }

  void
  test_unknown_names()
  {
    check_throws_with([] { parse("\nset Dimensoin = 2"); },
                      {"a.prm, line 2: unknown parameter <Dimensoin>",
                       "did you mean <Dimension>? Known at the top level: "
                       "Dimension, Title."});
    check_throws_with(
      [] {
        parse("subsection Materials\nsubsection rubber 7.1\n"
              "set Densty = 2\nend\nend");
      },
      {"a.prm, line 3: unknown parameter <Materials/rubber 7.1/Densty>",
       "did you mean <Density>? Known in <Materials/rubber 7.1>: "
       "Density, Young's modulus, Model."});
    check_throws_with([] { parse("subsection Grid\nset End time = 2\nend"); },
                      {"unknown parameter <Grid/End time>",
                       "it belongs to section <Time>.",
                       "Known in <Grid>: Lower corner, Force, "
                       "Periodic, Old force."});
    check_throws_with([] { parse("subsection Time\nset Title = 2\nend"); },
                      {"it belongs to the top level."});
    check_throws_with([] { parse("subsection Gird\nset Force = 2\nend"); },
                      {"a.prm, line 1: unknown section <Gird>",
                       "did you mean <Grid>? Known sections at the top level: "
                       "Materials, Grid, Time."});
    check_throws_with([] { parse("subsection rubber 7.1\nend"); },
                      {"it belongs to section <Materials>."});
    check_throws_with(
      [] { parse("subsection Time\nsubsection Nothing\nset A = 1\nend\nend"); },
      {"Known in <Time/Nothing>: none."});

    // a section is no entry, an entry no section
    check_throws_with([] { parse("set Grid = 2"); },
                      {"unknown parameter <Grid>"});
    check_throws_with([] { parse("subsection Title\nend"); },
                      {"unknown section <Title>"});

    // all of them in one error, each once, and nothing is set
    Scene             scene;
    const std::string many = "set Dimension = 3\n"
                             "set Titel = 1\n"
                             "subsection Gird\n"
                             "  subsection Deeper\n"
                             "    set Force = 1\n"
                             "  end\n"
                             "end\n"
                             "subsection Gird\n"
                             "end\n"
                             "subsection Time\n"
                             "  set Endtime = 1\n"
                             "end\n";
    std::string       message;
    try
      {
        text(many).parse(scene.prm);
      }
    catch (const std::exception &error)
      {
        message = error.what();
      }
    for (const char *const where : {"line 2:", "line 3:", "line 11:"})
      check(message.find(where) != std::string::npos, where + message);
    for (const char *const where : {"line 4:", "line 5:", "line 8:"})
      check(message.find(where) == std::string::npos, where + message);
    check(scene.get({}, "Dimension") == "2", "nothing is set after an error");

    // a ParameterHandler without any declaration
    ParameterHandler nothing;
    ParameterFile().parse(nothing);
    check_throws_with([&] { text("set A = 1").parse(nothing); },
                      {"Known at the top level: none."});
    check_throws_with([&] { text("subsection A\nend").parse(nothing); },
                      {"none; remove it, up to its <end>."});
  }

  void
  test_values()
  {
    check_throws_with(
      [] {
        parse("subsection Materials\nsubsection rubber 7.1\n"
              "set Density = five # kg\nend\nend");
      },
      {"a.prm, line 3: parameter <Materials/rubber 7.1/Density> is <five>",
       "it must be a number, at least 0. Mass per volume. Unit: kg/m^3."});
    check_throws_with([] { parse("set Dimension = 4"); },
                      {"<Dimension> is <4>",
                       "it must be a whole number, at least 2, at most 3."});
    check_throws_with([] { parse("subsection Grid\nset Periodic = 3\nend"); },
                      {"it must be true or false."});
    check_throws_with(
      [] { parse("subsection Grid\nset Lower corner = 1\nend"); },
      {"<Grid/Lower corner> is <1>",
       "it must be a list of 2 to 3 items separated by <,> or <;>, "
       "each a number. Unit: m."});
    check_throws_with(
      [] {
        parse("subsection Materials\nsubsection rubber 7.1\n"
              "set Model = Henky\nend\nend");
      },
      {"is <Henky>", "it must be one of Hencky, von Mises."});
    check_throws_with([] { parse("subsection Time\nset End time = 13\nend"); },
                      {"a.prm, line 2: parameter <Time/End time> is <13>",
                       "thirteen is unlucky"});
    check_throws_with([] { parse("subsection Time\nset End time = 14\nend"); },
                      {"<Time/End time> is <14>", "fourteen too"});
    check_throws_with(
      [] { parse("subsection Grid\nset Older force = a\nend"); },
      {"<Grid/Older force> is <a>", "a whole number"});

    // all of them in one error; prm is back at its top level
    Scene scene;
    check_throws_with(
      [&] {
        text("set Dimension = two\nsubsection Time\nset End time = -1\nend")
          .parse(scene.prm);
      },
      {"a.prm, line 1: parameter <Dimension> is <two>",
       "a.prm, line 3: parameter <Time/End time> is <-1>"});
    check(scene.prm.get("Dimension") == "2", "prm is at its top level");
    // also beside names that nobody knows
    check_throws_with(
      [&] {
        text("set Dimension = two\nset Titel = a\nsubsection Gird\n"
             "set Force = a\nend\nsubsection Time\nset End time = -1\nend")
          .parse(scene.prm);
      },
      {"a.prm, line 2: unknown parameter <Titel>",
       "a.prm, line 3: unknown section <Gird>",
       "a.prm, line 1: parameter <Dimension> is <two>",
       "it must be a whole number, at least 2, at most 3.",
       "a.prm, line 7: parameter <Time/End time> is <-1>"});
    check(scene.prm.get("Dimension") == "2", "nothing is set");

    text("subsection Grid\nset Older force = 3\nset Lower corner = 1, 2\nend")
      .parse(scene.prm);
    check(scene.get({"Grid"}, "Old force") == "3", "an alias is known");
    check_close(scene.corner.at(1), 2., 0., "a list arrives in its variable");
    text("subsection Grid\nset Lower corner = 3; 4; 5\nend").parse(scene.prm);
    check(scene.corner == std::vector<double>{3., 4., 5.},
          "semicolons separate as commas do");
  }

  // Commas or semicolons, whichever is written and wanted.
  void
  test_separators()
  {
    check(separated_by(';', "if(x > 0, min(a, (b, c)), 1), 2; 3") ==
            "if(x > 0, min(a, (b, c)), 1); 2; 3",
          "commas in parentheses separate nothing");
    const auto read = [](const std::string           &value,
                         const Patterns::PatternBase &pattern) {
      return as_declared(value,
                         pattern.description(Patterns::PatternBase::Machine));
    };
    const Patterns::List numbers(Patterns::Double(), 0, 3),
      counts(Patterns::Integer(0), 2, 2),
      by_semicolon(Patterns::Double(), 0, 3, ";"), nested(numbers, 0, 9, ";"),
      names(Patterns::Anything{});
    check(read("1; 2", numbers) == "1, 2", "numbers by commas");
    check(read("1; 2", counts) == "1, 2", "whole numbers");
    check(read("1, 2", by_semicolon) == "1; 2", "numbers by semicolons");
    check(read("1, 2; 3, 4", nested) == "1, 2; 3, 4", "lists of lists stay");
    check(read("a; b", names) == "a; b", "names stay");
    check(read("1; 2", Patterns::Anything()) == "1; 2", "texts stay");
  }
} // namespace

int
main()
{
  test_syntax();
  test_syntax_errors();
  test_includes();
  test_set();
  test_unknown_names();
  test_values();
  test_separators();
  return report();
}
