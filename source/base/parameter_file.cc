#include <emmy/base/declared_parameters.h>
#include <emmy/base/exceptions.h>
#include <emmy/base/parameter_file.h>
#include <emmy/base/text.h>

#include <deal.II/base/parameter_handler.h>
#include <deal.II/base/utilities.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

namespace emmy
{
  using dealii::Utilities::trim;
  using Path = std::vector<std::string>;

  namespace
  {
    /** A line without comment and outer blanks, continuations joined. */
    struct Line
    {
      unsigned int number; // of its first part, counted from 1
      std::string  text;
    };

    /** All lines that are not blank, cut up as ParameterHandler does it. */
    std::vector<Line>
    logical_lines(std::istream &input)
    {
      std::vector<Line> lines;
      const auto        finish = [&lines](const Line &raw) {
        std::string text = raw.text.substr(0, raw.text.find('#'));
        std::replace(text.begin(), text.end(), '\t', ' ');
        text = trim(text);
        if (!text.empty())
          lines.push_back({raw.number, text});
      };

      Line         joined{0, ""};
      unsigned int number = 0;
      for (std::string part; std::getline(input, part);)
        {
          ++number;
          if (number == 1 && part.compare(0, 3, "\xef\xbb\xbf") == 0)
            part.erase(0, 3); // the byte order mark of some editors
          if (joined.number == 0)
            joined.number = number;
          part = trim(part);

          const bool continues = !part.empty() && part.back() == '\\';
          joined.text += part.substr(0, part.size() - (continues ? 1 : 0));
          if (!continues)
            {
              finish(joined);
              joined = {0, ""};
            }
        }
      finish(joined); // the file may end in a backslash
      return lines;
    }


    std::string
    full_name(const Path &section, const std::string &name)
    {
      return section.empty() ? name : join(section, "/") + "/" + name;
    }

    /** Whether that is the full name; scenes ask often, so without making it.
     */
    bool
    is_path_of(const std::vector<std::string> &section,
               const std::string              &name,
               const std::string              &path)
    {
      std::size_t at = 0;
      for (const std::string &one : section)
        {
          if (path.compare(at, one.size(), one) != 0 ||
              at + one.size() >= path.size() || path[at + one.size()] != '/')
            return false;
          at += one.size() + 1;
        }
      return path.compare(at, std::string::npos, name) == 0;
    }


    /** Open a file to read. Opening a directory succeeds, but is no use. */
    std::ifstream
    open(const std::string &file,
         const std::string &where,
         const std::string &remedy)
    {
      std::ifstream input(file);
      AssertThrow(input && !std::filesystem::is_directory(file),
                  ExcRun(where, "cannot read the file <" + file + ">", remedy));
      return input;
    }


    /** The file to include, relative to the including one. */
    std::string
    included_file(const std::string &name,
                  const std::string &where,
                  const Path        &files)
    {
      namespace fs = std::filesystem;
      const std::string file =
        (fs::path(files.back()).parent_path() / name).lexically_normal();

      for (const std::string &outer : files)
        AssertThrow(fs::weakly_canonical(outer) != fs::weakly_canonical(file),
                    ExcRun(where,
                           "<" + file + "> would include itself: " +
                             join(files, " -> ") + " -> " + file,
                           "remove one of these include statements."));
      return file;
    }


    /** What to do about a line that is no statement. */
    std::string
    remedy_for_line(const std::string &keyword)
    {
      const std::string nearest =
        nearest_name(keyword, {"set", "subsection", "end", "include"});
      return (nearest.empty() ? "" : "did you mean <" + nearest + ">? ") +
             "write <set NAME = VALUE>, <subsection NAME>, <end>, "
             "<include FILE> or <# COMMENT>.";
    }


    struct Problem
    {
      std::string where, what, remedy;
    };

    std::string
    named_value(const Path        &section,
                const std::string &name,
                const std::string &value)
    {
      return "parameter <" + full_name(section, name) + "> is <" + value + ">";
    }

    Problem
    wrong_value(const std::string                     &where,
                const std::string                     &what,
                const DeclaredParameters::Declaration &entry)
    {
      return {where,
              what,
              "it must be " + in_words(entry.pattern) + ". " +
                entry.documentation};
    }

    bool
    is_value_of(const std::string &pattern, const std::string &value)
    {
      return dealii::Patterns::pattern_factory(pattern)->match(
        as_declared(value, pattern));
    }

    /** Throw all problems, if any, as one ExcRun in its own layout. */
    void
    throw_all(const std::vector<Problem> &problems)
    {
      if (problems.empty())
        return;
      std::string remedies = problems[0].remedy;
      for (std::size_t i = 1; i < problems.size(); ++i)
        remedies += "\n" + problems[i].where + ": " + problems[i].what +
                    "\n  Remedy: " + problems[i].remedy;
      AssertThrow(false, ExcRun(problems[0].where, problems[0].what, remedies));
    }
  } // namespace


  ParameterFile::ParameterFile(const std::string &filename)
  {
    std::ifstream input = open(filename,
                               "Reading the parameters",
                               "check the name and the working directory.");
    read(input, {}, {filename});
  }


  ParameterFile
  ParameterFile::from_text(const std::string &text, const std::string &label)
  {
    ParameterFile      result;
    std::istringstream input(text);
    result.read(input, {}, {label});
    return result;
  }


  void
  ParameterFile::read(std::istream &input, const Path &outer, const Path &files)
  {
    Path                               section = outer;
    std::vector<std::string>           opened_at;
    std::map<std::string, std::string> set_at; // in this file

    for (const Line &line : logical_lines(input))
      {
        const std::string where =
          files.back() + ", line " + std::to_string(line.number);
        const std::size_t blank   = line.text.find(' ');
        const std::string keyword = line.text.substr(0, blank);
        const std::string rest    = trim(line.text.substr(keyword.size()));
        const std::size_t equals  = rest.find('=');
        const std::string name    = trim(rest.substr(0, equals));
        const auto        is      = [&](const char *lower, const char *upper) {
          return keyword == lower || keyword == upper;
        };

        if (is("subsection", "SUBSECTION") && !rest.empty())
          {
            statements.push_back({section, rest, "", where, true});
            section.push_back(rest);
            opened_at.push_back(where);
          }
        else if (is("end", "END") && rest.empty())
          {
            AssertThrow(!opened_at.empty(),
                        ExcRun(where,
                               "this <end> closes no section of this file",
                               "remove it, or add the missing <subsection>."));
            section.pop_back();
            opened_at.pop_back();
          }
        else if (is("set", "SET") && equals != std::string::npos &&
                 !name.empty())
          {
            const std::string path     = full_name(section, name);
            const auto [first, is_new] = set_at.emplace(path, where);
            AssertThrow(is_new,
                        ExcRun(where,
                               "<" + path + "> is given a second time",
                               "the first is in " + first->second +
                                 "; keep one of them."));
            statements.push_back(
              {section, name, trim(rest.substr(equals + 1)), where, false});
          }
        else if (is("include", "INCLUDE") && !rest.empty())
          {
            Path nested = files;
            nested.push_back(included_file(rest, where, files));
            std::ifstream included =
              open(nested.back(),
                   where,
                   "check the name; it is relative to the including file.");
            read(included, section, nested);
          }
        else
          AssertThrow(false,
                      ExcRun(where,
                             "cannot understand <" + line.text + ">",
                             remedy_for_line(keyword)));
      }
    AssertThrow(opened_at.empty(),
                ExcRun(opened_at.back(),
                       "section <" + join(section, "/") +
                         "> is not closed before the end of the file",
                       "add the missing <end>."));
  }


  void
  ParameterFile::set(const std::string &assignment, const std::string &where)
  {
    const std::size_t equals = assignment.find('=');
    const std::string path   = assignment.substr(0, equals);
    // split_string_list() drops an empty last item
    Path names = dealii::Utilities::split_string_list(path + "/.", '/');
    names.pop_back();
    AssertThrow(equals != std::string::npos &&
                  std::count(names.begin(), names.end(), "") == 0 &&
                  assignment.find_first_of("#\n") == std::string::npos,
                ExcRun(where,
                       "cannot understand <" + assignment + ">",
                       (where == "--set" ? "write --set" : "it must be") +
                         std::string(" \"Section/Subsection/Name=value\", "
                                     "without # in the value.")));

    Path section;
    for (const std::string &name : names)
      {
        const bool is_entry = section.size() + 1 == names.size();
        statements.push_back(
          {section,
           name,
           is_entry ? trim(assignment.substr(equals + 1)) : "",
           where,
           !is_entry});
        section.push_back(name);
      }
  }


  std::string
  ParameterFile::value(const std::string &path,
                       const std::string &default_value) const
  {
    std::string result = default_value;
    for (const Statement &statement : statements)
      if (!statement.opens_section &&
          is_path_of(statement.section, statement.name, path))
        result = statement.value;
    return result;
  }


  std::vector<std::string>
  ParameterFile::entries_of(const std::string &section) const
  {
    std::vector<std::string> result;
    for (const Statement &statement : statements)
      if (!statement.opens_section && join(statement.section, "/") == section)
        result.push_back(statement.name);
    return result;
  }


  bool
  ParameterFile::has_section(const std::string &path) const
  {
    return std::any_of(statements.begin(),
                       statements.end(),
                       [&path](const Statement &statement) {
                         return statement.opens_section &&
                                full_name(statement.section, statement.name) ==
                                  path;
                       });
  }


  void
  ParameterFile::parse(dealii::ParameterHandler &prm) const
  {
    const DeclaredParameters declared(prm);
    std::vector<Problem>     problems;

    // Of an unknown section only the first opening is reported.
    std::set<std::string> unknown_sections;
    for (const auto &[section, name, value, where, opens] : statements)
      if (const std::string path = full_name(section, name);
          declared.has_section(section) &&
          !declared.find(section, name, opens) &&
          (!opens || unknown_sections.insert(path).second))
        problems.push_back(
          {where,
           (opens ? "unknown section <" : "unknown parameter <") + path + ">",
           declared.remedy_for_unknown(section, name, opens)});
    // one reading tells of wrong values beside them, and sets nothing
    if (!problems.empty())
      for (const Statement &statement : statements)
        if (const auto *entry =
              statement.opens_section ||
                  !declared.has_section(statement.section)
                ? nullptr
                : declared.find(statement.section, statement.name, false);
            entry && !is_value_of(entry->pattern, statement.value))
          problems.push_back(wrong_value(
            statement.where,
            named_value(statement.section, statement.name, statement.value),
            *entry));
    throw_all(problems);

    for (const auto &[section, name, value, where, opens] : statements)
      {
        if (opens)
          continue;
        const std::string what = named_value(section, name, value);

        for (const std::string &one : section)
          prm.enter_subsection(one);
        try
          {
            prm.set(name,
                    as_declared(value,
                                declared.find(section, name, false)->pattern));
          }
        catch (const dealii::ParameterHandler::ExcValueDoesNotMatchPattern &)
          {
            problems.push_back(
              wrong_value(where, what, *declared.find(section, name, false)));
          }
        catch (const dealii::ExceptionBase &error) // from the entry's action
          {
            problems.push_back({where, what, message_of(error)});
          }
        catch (const std::exception &error)
          {
            problems.push_back({where, what, error.what()});
          }
        for (std::size_t i = 0; i < section.size(); ++i)
          prm.leave_subsection();
      }
    throw_all(problems);
  }
} // namespace emmy
