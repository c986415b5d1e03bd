#include <deal.II/base/utilities.h>

#include <boost/algorithm/string/predicate.hpp>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/study/command_line.h>

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
  } // namespace

  std::string
  parameters_on(const std::string &topic, const std::string &listing)
  {
    TopicParts         parts(topic);
    std::istringstream lines(listing);
    for (std::string line; std::getline(lines, line);)
      parts.read(line);
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
