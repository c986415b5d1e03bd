// Facts about what a scene does not name. For each line of the libraries of
// effects, materials and shape functions: a scene that does not name it is the
// same, to the last bit, when the line is left out. What is the same: particle
// fields, entries of the matrices, columns and rows of the ledger, particles at
// the end. That the comparison sees differences is shown by naming each line.

#include <algorithm>
#include <cstring>
#include <map>

#include "../check.h"
#include "../scene.h"

using namespace emmy;
using test::check;

namespace
{
  constexpr unsigned int n_steps = 4;

  /** What must not depend on what is absent. */
  struct Trace
  {
    std::vector<std::string>                    fields, columns;
    std::size_t                                 n_entries = 0; ///< nonzeros
    std::vector<std::vector<double>>            rows;
    std::map<unsigned int, std::vector<double>> particles; ///< by id

    /** Which parts differ, in words; empty: none. */
    std::string
    difference_to(const Trace &other) const
    {
      std::string result;
      const auto  compare = [&result](const bool is_same, const char *what) {
        if (!is_same)
          result += (result.empty() ? "" : ", ") + std::string(what);
      };
      compare(fields == other.fields, "fields");
      compare(n_entries == other.n_entries, "entries");
      compare(columns == other.columns, "columns");
      compare(same_bits(rows, other.rows), "ledger");
      bool is_same = particles.size() == other.particles.size();
      for (const auto &[id, values] : particles)
        is_same = is_same && other.particles.count(id) == 1 &&
                  same_bits({values}, {other.particles.at(id)});
      compare(is_same, "particles");
      return result;
    }

    /** NaN equals itself, and -0 is not 0. */
    static bool
    same_bits(const std::vector<std::vector<double>> &a,
              const std::vector<std::vector<double>> &b)
    {
      return std::equal(a.begin(),
                        a.end(),
                        b.begin(),
                        b.end(),
                        [](const auto &x, const auto &y) {
                          return x.size() == y.size() &&
                                 std::memcmp(x.data(),
                                             y.data(),
                                             x.size() * sizeof(double)) == 0;
                        });
    }
  };

  template <int dim>
  Trace
  trace(const std::string &text)
  {
    const SceneParameters<dim> parameters(
      ParameterFile::from_text(text, "test"));
    test::RunningScene<dim> run(parameters);
    Trace                   result;
    for (const Field &field : run.scene.layout.fields())
      result.fields.push_back(field.name + " at " +
                              std::to_string(field.offset));
    run.advance(n_steps);
    result.n_entries =
      run.scene.stepper->grid_start().active->graph().n_nonzeros();
    result.columns = run.ledger.columns();
    result.rows    = run.ledger.rows();
    for (const auto &particle : run.scene.particles)
      {
        const auto properties = particle.get_properties();
        auto      &values     = result.particles[particle.get_id()];
        values.assign(properties.begin(), properties.end());
        for (unsigned int d = 0; d < dim; ++d)
          values.push_back(particle.get_location()[d]);
      }
    return result;
  }

  /** A library without one of its lines, for as long as this lives. */
  template <class AnyLibrary>
  class LeftOut
  {
  public:
    LeftOut(AnyLibrary &library, const std::string &name)
      : library(library)
      , complete(library)
    {
      library = {};
      for (const auto &entry : complete.list())
        if (entry.name != name)
          library.add(entry);
      check(library.list().size() + 1 == complete.list().size(),
            "a line can be left out: " + name);
    }
    ~LeftOut()
    {
      library = complete;
    }

  private:
    AnyLibrary      &library;
    const AnyLibrary complete;
  };

  /** What a scene chooses. */
  struct Choice
  {
    std::string              material;
    std::vector<std::string> effects;
    std::string              shape_functions = "linear";
    std::string              starved         = "free"; ///< nodes

    bool
    has(const std::string &name) const
    {
      return name == material || name == shape_functions ||
             std::count(effects.begin(), effects.end(), name) > 0;
    }
    std::string
    name() const
    {
      return material + ", " + shape_functions +
             (effects.empty() ? "" : ", " + join(effects));
    }
  };

  /** The section of an effect, if it has entries that are required. */
  std::string
  section_of(const std::string &effect, const std::string &more)
  {
    if (effect == "gravity")
      return "subsection Gravity\nset Acceleration = 0, -1" + more + "\nend\n";
    if (effect == "point load")
      return std::string("subsection Point load\nset Force = 0.3; 0") +
             (more.empty() ? "" : "; 0") + "\nset Points nearest to = 2, 1.5" +
             more + "\nend\n";
    if (effect == "surface loads")
      return "subsection Surface loads\nset Names = water\nsubsection water\n"
             "set Pressure = 1\nend\nend\n";
    if (effect == "mass damping")
      return "subsection Mass damping\nset Rate = 1\nend\n";
    if (effect == "viscous sides")
      return "subsection Viscous sides\nset Sides = x-min\nend\n";
    if (effect == "contact")
      return "subsection Contact\nset Groups = block | ledge\nend\n";
    if (effect == "tools")
      return "subsection Tools\nset Names = floor\nsubsection floor\n"
             "set Shape = plane\nset Reference point = 1, 0.9" +
             more + "\nsubsection plane\nset Normal = 0, 1" + more +
             "\nend\nend\nend\n";
    if (effect == "manufactured solution")
      return "subsection Manufactured solution\nset Period = 5\n"
             "subsection vibration\nset Lower corner = 1, 1" +
             std::string(more.empty() ? "" : ", 0.5") +
             "\nset Upper corner = 2.5, 2" + (more.empty() ? "" : ", 1.5") +
             "\nset Amplitude = 0.1, 0.1" + more + "\nend\nend\n";
    return "";
  }

  /** A soft block, free in its grid, that flies and deforms. */
  template <int dim>
  std::string
  block(const Choice &choice, const std::string &unused = "")
  {
    const std::string more = dim == 3 ? ", 0" : "";
    std::string       effects;
    for (const std::string &effect : choice.effects)
      effects += section_of(effect, more);
    std::string velocity = "set Initial velocity = 0.9 + 0.5*(x - 1.7) + "
                           "0.3*y; 0.2 - 0.4*(y - 1.5)";
    velocity += dim == 3 ? "; 0.1*x" : "";
    if (choice.has("manufactured solution"))
      velocity = "";   // the motion gives it
    std::string ledge; // a second body for what needs one
    if (choice.has("contact"))
      ledge = "subsection ledge\nset Shape = box\nset Material = m\n"
              "set Points per direction = 2\nsubsection box\n"
              "set Lower corner = 3, 1" +
              std::string(dim == 3 ? ", 0.5" : "") +
              "\nset Upper corner = 3.5, 2" + (dim == 3 ? ", 1.5" : "") +
              "\nend\nend\n";
    return "set Dimension = " + std::to_string(dim) +
           "\nsubsection Grid\nset Lower corner = 0, 0" + more +
           "\nset Upper corner = 4, 3" + (dim == 3 ? ", 2" : "") +
           "\nset Cells = 8, 6" + (dim == 3 ? ", 4" : "") +
           "\nend\nsubsection Materials\nset Names = m\nsubsection m\n"
           "set Model = " +
           choice.material +
           "\nset Density = 5\nset Young's modulus = 100\n"
           "set Poisson's ratio = 0.3\n" +
           (choice.material == "von Mises"
              ? "set Yield stress = 2\nset Hardening modulus = 5\n"
            : choice.material == "Drucker-Prager"
              ? "set Cohesion = 2\nset Friction angle = 20\n"
                "set Dilation angle = 5\n"
              : "") +
           "end\nend\nsubsection Bodies\nset Names = block" +
           (ledge.empty() ? "" : ", ledge") +
           "\n"
           "subsection block\nset Shape = box\nset Material = m\n"
           "set Points per direction = 2\n" +
           velocity + "\nsubsection box\nset Lower corner = 1, 1" +
           (dim == 3 ? ", 0.5" : "") + "\nset Upper corner = 2.3, 2" +
           (dim == 3 ? ", 1.5" : "") + "\nend\nend\n" + ledge +
           "end\nsubsection Effects\nset Names = " + join(choice.effects) +
           "\n" + effects + "end\nsubsection Method\nset Shape functions = " +
           choice.shape_functions + "\nset Starved nodes = " + choice.starved +
           "\nend\n" + unused +
           "subsection Time\nset End time = 2\nset Step rule = fixed\n"
           "set Step size = 0.125\nend\n";
  }

  /**
   * Leave out each line that the scene does not name, one at a time; and give
   * what belongs to choices without a line, but is not chosen.
   */
  template <int dim>
  void
  check_absent(const Choice &choice)
  {
    const std::string scene      = std::to_string(dim) + "D, " + choice.name();
    const Trace       all        = trace<dim>(block<dim>(choice));
    unsigned int      n_absent   = 0;
    const auto        check_same = [&](const std::string &what,
                                const std::string &unused) {
      const std::string difference =
        trace<dim>(block<dim>(choice, unused)).difference_to(all);
      check(difference.empty(), scene + ": " + what + " changes " + difference);
      ++n_absent;
    };
    const auto leave_out = [&](auto &library) {
      for (const std::string &name : library.names())
        if (!choice.has(name))
          {
            const LeftOut gone(library, name);
            check_same("leaving out <" + name + ">", "");
          }
    };
    leave_out(effect_library<dim>());
    leave_out(material_library<dim>());
    leave_out(shape_function_library<dim>());
    if (choice.shape_functions != "GIMP")
      check_same("an entry of GIMP",
                 "subsection Method\nset Domain update = corners\nend\n");
    check_same("the section of the diagnosis",
               "subsection Diagnosis\nset Report above = 1\nend\n");
    std::cout << std::left << std::setw(52) << scene << all.fields.size()
              << " fields, " << all.n_entries << " entries, "
              << all.columns.size() << " columns; " << n_absent
              << " things absent\n";
  }

  /** Naming a line, alone, is seen; without the line it cannot be named. */
  template <int dim>
  void
  check_present()
  {
    const Trace none = trace<dim>(block<dim>({"Hencky", {}}));
    const auto  check_seen =
      [&](auto &library, const std::string &name, const Choice &choice) {
        const std::string text       = block<dim>(choice);
        const std::string difference = trace<dim>(text).difference_to(none);
        check(!difference.empty(), "naming <" + name + "> changes something");
        std::cout << dim << "D, naming " << std::left << std::setw(22) << name
                  << "changes " << difference << '\n';
        const LeftOut gone(library, name);
        test::check_throws_with([&] { trace<dim>(text); }, {"<" + name + ">"});
      };
    for (const std::string &name : effect_library<dim>().names())
      check_seen(effect_library<dim>(), name, {"Hencky", {name}});
    for (const std::string &name : material_library<dim>().names())
      if (name != "Hencky")
        check_seen(material_library<dim>(), name, {name, {}});
    for (const std::string &name : shape_function_library<dim>().names())
      if (name != "linear")
        check_seen(shape_function_library<dim>(), name, {"Hencky", {}, name});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_present<2>();
  check_present<3>();
  check_absent<2>({"Hencky", {}});
  check_absent<3>({"Hencky", {}});
  check_absent<2>({"Hencky", {"point load"}, "GIMP"});
  check_absent<2>({"von Mises", {"ghost stabilisation"}});
  check_absent<3>({"von Mises", {"gravity"}, "linear", "follow"});
  return test::report();
}
