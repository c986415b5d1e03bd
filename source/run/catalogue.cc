#include <boost/algorithm/string/predicate.hpp>

#include <emmy/effects/effect.h>
#include <emmy/material/material.h>
#include <emmy/output/measurement.h>
#include <emmy/particles/shape.h>
#include <emmy/particles/stencils.h>
#include <emmy/run/catalogue.h>
#include <emmy/solve/linear_solver.h>

#include <algorithm>
#include <iomanip>
#include <ostream>

namespace emmy
{
  namespace
  {
    void
    print_group(std::ostream              &out,
                const std::string         &kind,
                const std::string         &entry,
                const std::vector<Choice> &choices)
    {
      std::size_t width = 20;
      for (const Choice &choice : choices)
        width = std::max(width, choice.name.size());
      out << kind << " (" << entry << ")\n";
      for (const Choice &choice : choices)
        out << "  " << std::left << std::setw(width) << choice.name << "  "
            << choice.description << '\n';
    }

    /** Both dimensions of a library; what only one has is marked. */
    template <class Library2, class Library3>
    std::vector<Choice>
    choices(const Library2 &plane, const Library3 &space)
    {
      const auto has = [](const auto &library, const std::string &name) {
        const auto names = library.names();
        return std::find(names.begin(), names.end(), name) != names.end();
      };
      std::vector<Choice> result;
      for (const auto &entry : space.list())
        result.push_back(
          {entry.name,
           entry.description + (has(plane, entry.name) ? "" : " (3D only)")});
      for (const auto &entry : plane.list())
        if (!has(space, entry.name))
          result.push_back({entry.name, entry.description + " (2D only)"});
      return result;
    }
  } // namespace

  void
  print_catalogue(std::ostream &out, const std::string &section)
  {
    const auto print = [&](const std::string         &kind,
                           const std::string         &entry,
                           const std::vector<Choice> &choices) {
      if (section.empty() ||
          boost::algorithm::istarts_with(entry, section + "/"))
        print_group(out, kind, entry, choices);
    };
    print("effects",
          "Effects/Names",
          choices(effect_library<2>(), effect_library<3>()));
    print("materials",
          "Materials/NAME/Model",
          choices(material_library<2>(), material_library<3>()));
    print("shapes",
          "Bodies/NAME/Shape",
          choices(shape_library<2>(), shape_library<3>()));
    print("shape functions",
          "Method/Shape functions",
          choices(shape_function_library<2>(), shape_function_library<3>()));
    print("measurements",
          "Measurements/NAME/Type",
          choices(measurement_library<2>(), measurement_library<3>()));
    print("linear solvers", "Solver/Linear solver", linear_solvers());
    print("preconditioners of GMRES and BiCGStab",
          "Solver/Preconditioner",
          preconditioners());
  }
} // namespace emmy
