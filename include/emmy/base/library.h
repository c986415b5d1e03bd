#ifndef emmy_base_library_h
#define emmy_base_library_h

#include <emmy/base/effect_card.h>
#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /**
   * An ordered list of the things of one kind that a parameter file can name:
   * materials, shapes, effects, ... Each has a name, one line that says what
   * it is (emmy --list prints it), a maker, and what it costs. Outside code
   * adds to it before a parameter file is read.
   *
   * @tparam Product  what is made: most often parameters, a class derived from
   *   ParameterAcceptor (a "section") that knows how to build the thing it
   *   describes; for things without parameters the thing itself.
   * @tparam Argument of the maker; for parameters the path of the section,
   *   e.g. "Materials/rubber"
   */
  template <class Product, class Argument = const std::string &>
  class Library
  {
  public:
    /** Makes a product. */
    using Maker = std::function<std::unique_ptr<Product>(Argument)>;

    /** One line. */
    struct Entry
    {
      std::string name;        ///< as in parameter files
      std::string description; ///< for `emmy --list`
      Maker       make;        ///< makes the product
      /** For the scene card. Name and setting are filled in by the scene. */
      EffectCard card = {};
    };

    /** Add an entry; a name that is there already is replaced. */
    void
    add(Entry entry)
    {
      for (auto &existing : entries)
        if (existing.name == entry.name)
          {
            existing = std::move(entry);
            return;
          }
      entries.push_back(std::move(entry));
    }

    /** All lines, in the order in which they were added. */
    const std::vector<Entry> &
    list() const
    {
      return entries;
    }

    /** Of all lines. */
    std::vector<std::string>
    names() const
    {
      std::vector<std::string> result;
      for (const auto &entry : entries)
        result.push_back(entry.name);
      return result;
    }

    /**
     * The entry of that name. Throws ExcParameter for @p section and
     * @p parameter with the valid names, nearest first, if there is none.
     */
    const Entry &
    find(const std::string &name,
         const std::string &section,
         const std::string &parameter) const
    {
      for (const auto &entry : entries)
        if (entry.name == name)
          return entry;
      const std::string nearest = nearest_name(name, names());
      AssertThrow(false,
                  ExcParameter(section,
                               parameter,
                               name,
                               (nearest.empty()
                                  ? std::string()
                                  : "did you mean <" + nearest + ">? ") +
                                 "Known are: " + join(names()) + "."));
      return entries.front();
    }

  private:
    std::vector<Entry> entries;
  };
} // namespace emmy

#endif
