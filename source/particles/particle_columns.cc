#include <emmy/particles/particle_columns.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace emmy
{
  namespace
  {
    /** The words of a line, whatever separates them. */
    std::vector<std::string>
    words_of(std::string line)
    {
      std::replace_if(
        line.begin(),
        line.end(),
        [](const char letter) {
          return letter == ',' || letter == ';' || letter == '\t' ||
                 letter == '\r';
        },
        ' ');
      std::istringstream       stream(line);
      std::vector<std::string> words;
      for (std::string word; stream >> word;)
        words.push_back(word);
      return words;
    }

    /** Of a line; empty where a word is no finite number. */
    std::vector<double>
    numbers_in(const std::vector<std::string> &words)
    {
      std::vector<double> numbers;
      for (const std::string &word : words)
        {
          char *end = nullptr;
          numbers.push_back(std::strtod(word.c_str(), &end));
          if (*end != '\0' || !std::isfinite(numbers.back()))
            return {};
        }
      return numbers;
    }
  } // namespace

  int
  ParticleColumns::find(const std::string &name) const
  {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : found - names.begin();
  }

  ParticleColumns
  read_text_columns(const std::string &file)
  {
    ParticleColumns result;
    std::ifstream   in(file);
    unsigned int    n_lines = 0;
    for (std::string line; std::getline(in, line);)
      {
        ++n_lines;
        const auto words = words_of(line);
        if (words.empty() || words[0][0] == '#')
          continue;
        const std::string where = "line " + std::to_string(n_lines) + ": ";
        if (result.names.empty())
          {
            result.names = words;
            for (const std::string &name : words)
              if (std::count(words.begin(), words.end(), name) > 1)
                result.problem = where + "two columns <" + name + ">";
          }
        else if (auto numbers = numbers_in(words);
                 numbers.size() == result.names.size())
          result.rows.push_back(std::move(numbers));
        else
          result.problem = where + "it should hold " +
                           std::to_string(result.names.size()) +
                           " finite numbers, one a column";
        if (!result.problem.empty())
          break;
      }
    return result;
  }
} // namespace emmy
