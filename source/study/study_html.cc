#include <deal.II/base/utilities.h>

#include <emmy/study/study_html.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <vector>

namespace emmy
{
  namespace
  {
    constexpr const char *head =
      R"html(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Study</title>
<style>
body { font: 15px/1.45 sans-serif; color: #1b1f24; max-width: 1180px; margin: 1.5em auto; padding: 0 1em; }
h1 { font-size: 1.6em; margin-bottom: 0.2em; }
h2 { font-size: 1.15em; border-bottom: 1px solid #c8ccd0; margin-top: 1.8em; }
pre { background: #f5f6f8; padding: 0.8em; overflow-x: auto; }
code { background: #f5f6f8; padding: 0.1em 0.3em; }
.table { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; }
td, th { padding: 0.2em 1.2em 0.2em 0; text-align: left; border-bottom: 1px solid #e3e6e9; }
img { max-width: 100%; }
@media print { body { max-width: none; font-size: 11px; } table, img { break-inside: avoid; } }
</style>
</head>
<body>
)html";

    std::string
    escaped(const std::string &line)
    {
      std::string text;
      for (const char letter : line)
        text += letter == '&'   ? "&amp;"
                : letter == '<' ? "&lt;"
                : letter == '>' ? "&gt;"
                : letter == '"' ? "&quot;"
                                : std::string(1, letter);
      return text;
    }

    /** Words of a line: marks of Markdown become those of HTML. */
    std::string
    words(const std::string &line)
    {
      return std::regex_replace(std::regex_replace(escaped(line),
                                                   std::regex("`([^`]+)`"),
                                                   "<code>$1</code>"),
                                std::regex("\\*\\*([^*]+)\\*\\*"),
                                "<b>$1</b>");
    }

    /** A picture as a part of the page; empty if it is not there. */
    std::string
    picture(const std::string &name, const std::string &file)
    {
      std::ifstream                    in(file, std::ios::binary);
      const std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(in),
                                             {}};
      if (bytes.empty())
        return "";
      return "<p><img alt=\"" + escaped(name) +
             "\" src=\"data:image/png;base64," +
             dealii::Utilities::encode_base64(bytes) + "\"></p>\n";
    }

    /** A row of a table; "\|" is a bar in a cell. */
    std::string
    row(const std::string &line, const std::string &mark)
    {
      std::string result = "<tr>", cell;
      for (std::size_t i = 1; i < line.size(); ++i)
        if (line[i] == '\\' && i + 1 < line.size() && line[i + 1] == '|')
          cell += line[++i];
        else if (line[i] != '|')
          cell += line[i];
        else
          {
            result += '<' + mark + '>' + words(dealii::Utilities::trim(cell)) +
                      "</" + mark + '>';
            cell.clear();
          }
      return result + "</tr>\n";
    }

    /** What kind of block a line belongs to: "p" if no other. */
    std::string
    kind_of(const std::string &line)
    {
      const auto begins = [&](const std::string &text) {
        return line.compare(0, text.size(), text) == 0;
      };
      return line.empty()     ? ""
             : begins("# ")   ? "h1"
             : begins("## ")  ? "h2"
             : begins("|")    ? "table"
             : begins("- ")   ? "ul"
             : begins("    ") ? "pre"
             : begins("![")   ? "img"
                              : "p";
    }

    /** The lines of a block, one after the other. */
    std::string
    block(const std::string              &kind,
          const std::vector<std::string> &lines,
          const std::string              &folder)
    {
      std::string result;
      for (std::size_t i = 0; i < lines.size(); ++i)
        if (kind == "table")
          result += i == 1 ? "" : row(lines[i], i == 0 ? "th" : "td");
        else if (kind == "ul")
          result += "<li>" + words(lines[i].substr(2)) + "</li>\n";
        else if (kind == "pre")
          result += words(lines[i].substr(4)) + '\n';
        else if (kind == "img")
          {
            std::smatch found;
            if (std::regex_match(lines[i],
                                 found,
                                 std::regex("!\\[(.*)\\]\\((.*)\\)")))
              result += picture(found[1], folder + '/' + found[2].str());
          }
        else
          result +=
            words(kind == "p" ? lines[i] : lines[i].substr(kind[1] - '0' + 1)) +
            '\n';
      if (kind == "img")
        return result;
      result = '<' + kind + ">\n" + result + "</" + kind + ">\n";
      return kind == "table" ? "<div class=\"table\">\n" + result + "</div>\n"
                             : result;
    }
  } // namespace

  std::string
  study_as_html(const std::string &markdown, const std::string &folder)
  {
    std::string              result = head, kind;
    std::vector<std::string> lines;
    const auto               flush = [&] {
      if (!lines.empty())
        result += block(kind, lines, folder);
      lines.clear();
    };
    std::istringstream in(markdown);
    for (std::string line; std::getline(in, line);)
      {
        const std::string next = kind_of(line);
        // lines that follow those of a list belong to its last item
        if (next == "p" && kind == "ul" && !lines.empty())
          {
            lines.back() += ' ' + line;
            continue;
          }
        if (next != kind || next == "h2")
          flush();
        kind = next;
        if (!line.empty())
          lines.push_back(line);
      }
    flush();
    return result + "</body>\n</html>\n";
  }
} // namespace emmy
