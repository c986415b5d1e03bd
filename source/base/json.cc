#include <emmy/base/json.h>
#include <emmy/base/text.h>

#include <cmath>
#include <cstdio>

namespace emmy
{
  namespace
  {
    /** Text in quotes, with what JSON does not allow in them escaped. */
    std::string
    quoted(const std::string &text)
    {
      std::string result = "\"";
      for (const char c : text)
        if (c == '"' || c == '\\')
          (result += '\\') += c;
        else if (static_cast<unsigned char>(c) < 0x20)
          {
            char code[7];
            std::snprintf(code, sizeof(code), "\\u%04x", c);
            result += code;
          }
        else
          result += c;
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
