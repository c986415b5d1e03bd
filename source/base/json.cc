#include <emmy/base/json.h>
#include <emmy/base/text.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace emmy
{
  namespace
  {
    /**
     * How many bytes of a text from @p i on are one character in UTF-8; 0 if
     * they are none (table 3-7 of the Unicode standard).
     */
    unsigned int
    length_in_utf8(const std::string &text, const std::size_t i)
    {
      const auto is_between = [&](const std::size_t  at,
                                  const unsigned int first,
                                  const unsigned int last) {
        const unsigned char c = at < text.size() ? text[at] : 0;
        return c >= first && c <= last;
      };
      if (is_between(i, 0, 0x7f))
        return 1;
      const unsigned char lead = text[i];
      const unsigned int  n    = is_between(i, 0xc2, 0xdf)   ? 2
                                 : is_between(i, 0xe0, 0xef) ? 3
                                 : is_between(i, 0xf0, 0xf4) ? 4
                                                             : 0;
      // neither longer than need be, nor a surrogate, nor beyond 10ffff
      if (n == 0 || !is_between(i + 1,
                                lead == 0xe0   ? 0xa0
                                : lead == 0xf0 ? 0x90
                                               : 0x80,
                                lead == 0xed   ? 0x9f
                                : lead == 0xf4 ? 0x8f
                                               : 0xbf))
        return 0;
      for (unsigned int j = 2; j < n; ++j)
        if (!is_between(i + j, 0x80, 0xbf))
          return 0;
      return n;
    }

    /**
     * Text in quotes, with what JSON does not allow in them escaped. A byte
     * that is not UTF-8 is read as Latin-1, as names in old files can be.
     */
    std::string
    quoted(const std::string &text)
    {
      std::string result = "\"";
      for (std::size_t i = 0; i < text.size();)
        {
          const unsigned int  n = length_in_utf8(text, i);
          const unsigned char c = text[i];
          if (c == '"' || c == '\\')
            result += '\\';
          if (n == 0 || c < 0x20)
            {
              char code[7];
              std::snprintf(code, sizeof(code), "\\u%04x", c);
              result += code;
            }
          else
            result += text.substr(i, n);
          i += std::max(n, 1u);
        }
      return result + '"';
    }
  } // namespace

  void
  JsonObject::add(const std::string &name, const double number)
  {
    entries.emplace_back(name,
                         std::isfinite(number) ? shortest(number) : "null");
  }

  void
  JsonObject::add(const std::string &name, const std::string &text)
  {
    entries.emplace_back(name, quoted(text));
  }

  void
  JsonObject::add(const std::string &name, const JsonObject &object)
  {
    entries.emplace_back(name, object.line());
  }

  void
  JsonObject::add(const std::string &name, const std::vector<JsonObject> &list)
  {
    std::string value = "[";
    for (std::size_t i = 0; i < list.size(); ++i)
      value += (i == 0 ? "\n    " : ",\n    ") + list[i].line();
    entries.emplace_back(name, value + (list.empty() ? "]" : "\n  ]"));
  }

  std::string
  JsonObject::line() const
  {
    std::vector<std::string> parts;
    for (const auto &[name, value] : entries)
      parts.push_back(quoted(name) + ": " + value);
    return "{" + join(parts) + "}";
  }

  std::string
  JsonObject::text() const
  {
    std::vector<std::string> parts;
    for (const auto &[name, value] : entries)
      parts.push_back("  " + quoted(name) + ": " + value);
    return "{\n" + join(parts, ",\n") + "\n}\n";
  }
} // namespace emmy
