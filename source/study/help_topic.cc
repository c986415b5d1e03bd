#include <deal.II/base/utilities.h>

#include <boost/algorithm/string/classification.hpp>
#include <boost/algorithm/string/predicate.hpp>
#include <boost/algorithm/string/trim.hpp>

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

    /** Collects the parts of a listing line by line. What is said of an entry
     * stands once, above the first of its name: the tools share many. */
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
            add(comment + line + "\n");
          }
        else if (starts_with(text, "set "))
          {
            const std::string name =
              dealii::Utilities::trim(text.substr(4, text.find('=') - 4));
            enter(name);
            const bool is_new = tell(name);
            add((is_new ? comment : "") + line + "\n");
            leave();
          }
        else if (text.empty() || starts_with(text, "#"))
          {
            comment += line + "\n";
            return;
          }
        else
          {
            add(comment + line + "\n");
            if (text == "end")
              leave();
          }
        comment.clear();
      }

      std::string              result;
      std::vector<std::string> known;              ///< names and paths
      bool                     leaves_out = false; ///< what was said before

    private:
      void
      enter(const std::string &name)
      {
        path.push_back(name);
        const std::string whole = join(path, "/");
        known.insert(known.end(), {whole, name});
        if (shown == 0 && (iequals(whole, topic) || iequals(name, topic)))
          {
            result += (result.empty() ? "" : "\n") + whole + "\n";
            boost::algorithm::trim_left_if(comment,
                                           boost::algorithm::is_any_of("\n"));
            shown = path.size();
          }
      }

      /** Whether what is said of an entry was not said before. */
      bool
      tell(const std::string &name)
      {
        const bool is_new =
          shown == 0 ||
          told.insert(name + dealii::Utilities::trim(comment)).second;
        leaves_out = leaves_out || !is_new;
        return is_new;
      }

      void
      add(const std::string &lines)
      {
        if (shown > 0)
          result += lines;
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
      std::size_t           shown = 0; ///< depth of what is shown; 0: nothing
      std::string           comment;   ///< above the line, with what is blank
      std::set<std::string> told;      ///< names of entries with what is said
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
    else if (parts.leaves_out)
      parts.result +=
        "\nEntries without a word are as those of the same name above.\n";
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
