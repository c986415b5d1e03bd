#include <emmy/base/declared_parameters.h>
#include <emmy/base/formula.h>
#include <emmy/base/text.h>

#include <deal.II/base/parameter_handler.h>
#include <deal.II/base/utilities.h>

#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>

#include <limits>
#include <regex>
#include <sstream>

namespace emmy
{
  namespace
  {
    /** Undo ParameterHandler's encoding of names: Young_27s_20modulus. */
    std::string
    demangle(const std::string &name)
    {
      std::string result;
      for (std::size_t i = 0; i < name.size(); ++i)
        if (name[i] == '_')
          {
            result += char(std::stoi(name.substr(i + 1, 2), nullptr, 16));
            i += 2;
          }
        else
          result += name[i];
      return result;
    }
  } // namespace


  // XML, since the JSON output splits names at points.
  DeclaredParameters::DeclaredParameters(const dealii::ParameterHandler &prm)
  {
    std::stringstream xml;
    prm.print_parameters(xml,
                         dealii::ParameterHandler::XML |
                           dealii::ParameterHandler::KeepDeclarationOrder);
    boost::property_tree::ptree tree;
    read_xml(xml, tree);
    collect(tree.get_child("ParameterHandler"), {});
  }


  void
  DeclaredParameters::collect(const boost::property_tree::ptree &tree,
                              const Path                        &home)
  {
    for (const auto &mangled_and_node : tree)
      {
        const std::string name = demangle(mangled_and_node.first);
        const auto       &node = mangled_and_node.second;
        const auto        text = [&node](const std::string &field) {
          return node.get<std::string>(field, "");
        };
        // What describes an entry are leaves; what a section holds is not.
        const auto has_leaf = [&node](const std::string &field) {
          const auto child = node.find(field);
          return child != node.not_found() && child->second.empty();
        };

        if (has_leaf("value"))
          add({home,
               name,
               Kind::entry,
               text("pattern_description"),
               text("documentation")});
        else if (has_leaf("alias"))
          {
            Declaration alias = *find(home, text("alias"), false);
            alias.name        = name;
            alias.kind        = Kind::alias;
            add(alias);
          }
        else
          {
            add({home, name, Kind::section, "", ""});
            Path section = home;
            section.push_back(name);
            collect(node, section);
          }
      }
  }


  const DeclaredParameters::Declaration *
  DeclaredParameters::find(const Path        &home,
                           const std::string &name,
                           const bool         is_section) const
  {
    const auto &of_kind = is_section ? sections : entries;
    const auto  found   = of_kind.find({home, name});
    return found == of_kind.end() ? nullptr : &declarations[found->second];
  }


  void
  DeclaredParameters::add(const Declaration &declaration)
  {
    // the first of a name counts
    (declaration.kind == Kind::section ? sections : entries)
      .insert({{declaration.home, declaration.name}, declarations.size()});
    declarations.push_back(declaration);
  }


  bool
  DeclaredParameters::has_section(const Path &section) const
  {
    return section.empty() || find(Path(section.begin(), section.end() - 1),
                                   section.back(),
                                   true) != nullptr;
  }


  std::string
  DeclaredParameters::remedy_for_unknown(const Path        &home,
                                         const std::string &name,
                                         const bool         is_section) const
  {
    std::vector<std::string> known, homes;
    for (const Declaration &one : declarations)
      if (one.kind == (is_section ? Kind::section : Kind::entry))
        {
          if (one.home == home)
            known.push_back(one.name);
          if (one.name == name)
            homes.push_back(one.home.empty()
                              ? "the top level"
                              : "section <" + join(one.home, "/") + ">");
        }
    if (homes.size() > 3) // many bodies declare the same names
      {
        homes.resize(3);
        homes.push_back("...");
      }

    const std::string nearest = nearest_name(name, known);
    return (!homes.empty()     ? "it belongs to " + join(homes, " or ") + ". "
            : !nearest.empty() ? "did you mean <" + nearest + ">? "
                               : "") +
           (is_section ? "Known sections " : "Known ") +
           (home.empty() ? "at the top level"
                         : "in <" + join(home, "/") + ">") +
           ": " +
           (!known.empty() ? join(known)
            : is_section   ? "none; remove it, up to its <end>"
                           : "none") +
           "." +
           (is_section && find(home, "Names", false)
              ? " A new name must stand in <" + join(home, "/") + "/Names>."
              : "");
  }


  namespace
  {
    const std::regex
      number(R"(\[(Double|Integer range) (.+)\.\.\.(.+) \(inclusive\)\])");
    const std::regex
      list(R"(\[List of <(.*)> of length (\d+)\.\.\.(\d+) \(inclusive\))"
           R"((?: separated by <(.*)>)?\])");

    /** Whether the items of a list are numbers, by their pattern. */
    bool
    are_numbers(const std::string &pattern)
    {
      return pattern == "[Double]" || pattern == "[Integer]" ||
             std::regex_match(pattern, number);
    }
  } // namespace


  std::string
  as_declared(const std::string &value, const std::string &pattern)
  {
    std::smatch part;
    if (value.find_first_of(",;") == std::string::npos ||
        !std::regex_match(pattern, part, list) || !are_numbers(part[1]))
      return value;
    const std::string separator = part[4];
    return separated_by(separator == ";" ? ';' : ',', value);
  }


  std::string
  in_words(const std::string &pattern)
  {
    static const std::regex  selection(R"(\[(Multiple)?Selection (.*) \])");
    static const std::string max_length =
      std::to_string(std::numeric_limits<unsigned int>::max());

    std::smatch part;
    if (std::regex_match(pattern, part, number))
      {
        const bool is_double = part[1] == "Double";
        const bool is_bounded_below =
          part[2] != (is_double ? "-MAX_DOUBLE" : "-2147483648");
        const bool is_bounded_above =
          part[3] != (is_double ? "MAX_DOUBLE" : "2147483647");
        return std::string(is_double ? "a number" : "a whole number") +
               (is_bounded_below ? ", at least " + part[2].str() : "") +
               (is_bounded_above ? ", at most " + part[3].str() : "");
      }
    if (std::regex_match(pattern, part, selection))
      return (part[1].matched ? "some of " : "one of ") +
             join(dealii::Utilities::split_string_list(part[2], '|'));
    if (std::regex_match(pattern, part, list))
      {
        const std::string from = part[2], to = part[3], separator = part[4];
        if (from == "0" && to == "1")
          return in_words(part[1]) + ", or nothing";
        return "a list of " +
               (from == to         ? from
                : to != max_length ? from + " to " + to
                : from == "0"      ? "any number of"
                                   : "at least " + from) +
               " items separated by " +
               (are_numbers(part[1]) ? "<,> or <;>"
                : separator.empty()  ? "<,>"
                                     : "<" + separator + ">") +
               ", each " + in_words(part[1]);
      }
    return pattern == "[Bool]"                             ? "true or false"
           : pattern == "[Double]"                         ? "a number"
           : pattern == "[Integer]"                        ? "a whole number"
           : pattern == "[Anything]"                       ? "any text"
           : pattern.compare(0, 9, "[FileName") == 0       ? "a file name"
           : pattern.compare(0, 14, "[DirectoryName") == 0 ? "a directory name"
                                                           : pattern;
  }
} // namespace emmy
