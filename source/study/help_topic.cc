#include <deal.II/base/utilities.h>

#include <boost/algorithm/string/predicate.hpp>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/study/command_line.h>

#include <set>
#include <sstream>

namespace emmy
{
  namespace
  {
    using boost::algorithm::iequals;
    using boost::algorithm::starts_with;

    /** Collects the parts of a listing line by line. */
    class TopicParts
    {
    public:
      explicit TopicParts(const std::string &topic)
        : topic(topic)
      {}

      void
      read(const std::string &line)
      {
        const std::string text = dealii::Utilities::trim(line);
        if (starts_with(text, "subsection "))
          {
            enter(text.substr(11));
            add(line);
          }
        else if (starts_with(text, "set "))
          {
            enter(dealii::Utilities::trim(text.substr(4, text.find('=') - 4)));
            add(line);
            leave();
          }
        else
          {
            add(line);
            if (text == "end")
              leave();
          }
        comment = starts_with(text, "#") ? comment + line + "\n" : "";
      }

      std::string              result;
      std::vector<std::string> known; ///< names and paths

    private:
      void
      enter(const std::string &name)
      {
        path.push_back(name);
        const std::string whole = join(path, "/");
        known.insert(known.end(), {whole, name});
        if (shown == 0 && (iequals(whole, topic) || iequals(name, topic)))
          {
            result += (result.empty() ? "" : "\n") + whole + "\n" + comment;
            shown = path.size();
          }
      }

      void
      add(const std::string &line)
      {
        if (shown > 0)
          result += line + "\n";
      }

      void
      leave()
      {
        if (shown == path.size())
          shown = 0;
        path.pop_back();
      }

      const std::string        topic;
      std::vector<std::string> path;
      std::size_t shown = 0; ///< depth of what is shown; 0: nothing
      std::string comment;   ///< above the line
    };
    /** Entries whose name or text has the word; empty: none. */
    std::string
    entries_about(const std::string &word, const std::string &listing)
    {
      std::vector<std::string> path;
      std::string              comment, result;
      std::set<std::string>    told;
      std::istringstream       lines(listing);
      for (std::string line; std::getline(lines, line);)
        {
          const std::string text     = dealii::Utilities::trim(line);
          const bool        is_entry = starts_with(text, "set ");
          if (starts_with(text, "subsection "))
            path.push_back(text.substr(11));
          else if (text == "end")
            path.pop_back();
          else if (is_entry)
            path.push_back(
              dealii::Utilities::trim(text.substr(4, text.find('=') - 4)));
          if (is_entry)
            {
              const std::string whole = join(path, "/");
              // models and bodies share entries
              if (boost::algorithm::icontains(whole + comment, word) &&
                  told.insert(path.back() + comment).second)
                result += "\n" + whole + "\n" + comment;
              path.pop_back();
            }
          if (starts_with(text, "#"))
            comment += "  " + text + "\n";
          else
            comment.clear();
        }
      return result.empty() ? result
                            : "No section or entry is named <" + word +
                                ">; these speak of it:\n" + result;
    }
  } // namespace

  std::string
  parameters_on(const std::string &topic, const std::string &listing)
  {
    TopicParts         parts(topic);
    std::istringstream lines(listing);
    for (std::string line; std::getline(lines, line);)
      parts.read(line);
    if (parts.result.empty())
      parts.result = entries_about(topic, listing);
    const std::string nearest = nearest_name(topic, parts.known);
    AssertThrow(!parts.result.empty(),
                ExcRun("Command line",
                       "no help on <" + topic + ">",
                       (nearest.empty() ? ""
                                        : "did you mean <" + nearest + ">? ") +
                         "Write a section or an entry of parameter files, as "
                         "emmy --print-parameters lists them, e.g. emmy --help "
                         "Effects/Gravity."));
    return parts.result;
  }
} // namespace emmy
