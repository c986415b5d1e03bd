#ifndef emmy_base_json_h
#define emmy_base_json_h

#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /**
   * Text of a JSON object, entry by entry in the order in which they are
   * added. There is no library at hand that keeps numbers: the writer of
   * boost::property_tree puts them in quotes.
   */
  class JsonObject
  {
  public:
    /** With the digits that give it back exactly; null if not finite. */
    void
    add(const std::string &name, const double number);
    void
    add(const std::string &name, const std::string &text);
    void
    add(const std::string &name, const JsonObject &object);
    /** One line for each object. */
    void
    add(const std::string &name, const std::vector<JsonObject> &list);

    /** On one line. */
    std::string
    line() const;

    /** A line for each entry, and a line break at the end. */
    std::string
    text() const;

  private:
    /** Name and value as JSON. */
    std::vector<std::pair<std::string, std::string>> entries;
  };
} // namespace emmy

#endif
