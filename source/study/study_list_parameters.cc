#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/study/study_list_parameters.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    /** Items between separators; blank ones too, as a value may be empty. */
    std::vector<std::string>
    split(const std::string &text, const char separator)
    {
      // split_string_list() drops an empty last item
      auto items =
        dealii::Utilities::split_string_list(text + separator + ".", separator);
      items.pop_back();
      return items;
    }

    /** The numbers that the words are, all positive; else none. */
    std::vector<double>
    numbers(const std::vector<std::string> &words)
    {
      std::vector<double> result;
      for (const std::string &word : words)
        {
          char *end = nullptr;
          result.push_back(std::strtod(word.c_str(), &end));
          if (word.empty() || *end != '\0' || !(result.back() > 0.))
            return {};
        }
      return result;
    }
  } // namespace

  std::string
  join_numbers(const std::vector<double> &values)
  {
    std::vector<std::string> words;
    for (const double value : values)
      words.push_back(shortest(value));
    return join(words);
  }

  StudyListParameters::StudyListParameters(const std::string &path)
    : Section(path)
  {
    add_parameter("Entries",
                  entries,
                  "The entry of the base scene that the list varies, e.g. "
                  "Time/Step size. Several, with | between them, all take "
                  "the same value, or each its part of it. Ranks: how many "
                  "ranks run the member. Required.");
    add_parameter("Values",
                  values,
                  "The values, with | between them, from coarse to fine. "
                  "One may be empty. With & in a value each entry takes "
                  "one part of it. Required.");
    add_parameter("Value names",
                  value_names,
                  "What the values are called in tables and pictures, "
                  "with | between them. Empty: as they are.");
    add_parameter("Sizes",
                  sizes,
                  "A positive number for each value that orders and "
                  "errors are measured against, e.g. the edge of a cell. "
                  "Empty: the values themselves, or their names, if they "
                  "are numbers.");
    add_parameter("Label",
                  label,
                  "What the sizes are, with their unit, for an axis of "
                  "the pictures. Empty: the name of the list.");
  }

  StudyList
  StudyListParameters::list(const std::string &name) const
  {
    const auto require = [this](const bool         condition,
                                const std::string &entry,
                                const std::string &value,
                                const std::string &advice) {
      AssertThrow(condition, ExcParameter(path(), entry, value, advice));
    };
    StudyList result{name,
                     split(entries, '|'),
                     split(value_names.empty() ? values : value_names, '|'),
                     {},
                     sizes,
                     label.empty() ? name : label};
    for (const std::string &entry : result.entries)
      {
        require(!entry.empty(),
                "Entries",
                entries,
                "name an entry of the base scene, e.g. Time/Step size.");
        require(entry != "Output/Directory" && entry != "Output/Overwrite",
                "Entries",
                entries,
                "the study chooses each member's folder. Vary another "
                "entry.");
      }
    require(!values.empty(),
            "Values",
            values,
            "it is required. Separate values by |, e.g. 0.1 | 0.05.");
    for (const std::string &value : result.values)
      require(std::count(result.values.begin(), result.values.end(), value) ==
                1,
              value_names.empty() ? "Values" : "Value names",
              value_names.empty() ? values : value_names,
              "<" + value + "> is there twice. Remove one of them.");
    for (const std::string &value : split(values, '|'))
      {
        const bool has_parts = value.find('&') != std::string::npos;
        result.settings.push_back(
          has_parts ? split(value, '&')
                    : std::vector<std::string>(result.entries.size(), value));
        require(result.settings.back().size() == result.entries.size(),
                "Values",
                value,
                "give one part for each of the " +
                  std::to_string(result.entries.size()) + " entries.");
      }
    require(result.settings.size() == result.values.size(),
            "Value names",
            value_names,
            "give one for each of the " +
              std::to_string(result.settings.size()) + " values, or none.");
    require(sizes.empty() || sizes.size() == result.values.size(),
            "Sizes",
            join_numbers(sizes),
            "give one for each of the " + std::to_string(result.values.size()) +
              " values, or none.");
    if (sizes.empty())
      result.sizes = numbers(split(values, '|'));
    if (sizes.empty() && result.sizes.empty())
      result.sizes = numbers(result.values);
    for (const double size : sizes)
      require(size > 0., "Sizes", shortest(size), "sizes must be positive.");
    for (const auto &setting : result.settings)
      require(!result.is_ranks() ||
                (setting.size() == 1 &&
                 dealii::Patterns::Integer(1).match(setting.front())),
              "Values",
              values,
              "Ranks takes numbers, e.g. 1 | 2, and stands alone.");
    return result;
  }
} // namespace emmy
