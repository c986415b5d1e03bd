#ifndef emmy_base_declared_parameters_h
#define emmy_base_declared_parameters_h

#include <boost/property_tree/ptree_fwd.hpp>

#include <map>
#include <string>
#include <utility>
#include <vector>

// Forward declaration
namespace dealii
{
  class ParameterHandler;
}

namespace emmy
{
  /**
   * The sections and entries that a ParameterHandler declares, which it does
   * not tell directly: they are taken from what it prints. For messages about
   * names and values that it does not know.
   *
   * Made while a parameter file is checked, and a copy: later declarations
   * are not seen. To find a name costs a look-up, a remedy a pass over all
   * declarations.
   */
  class DeclaredParameters
  {
  public:
    using Path = std::vector<std::string>; ///< section names, outermost first

    /** What a declaration is. */
    enum class Kind
    {
      entry,
      alias, // another name of an entry
      section
    };

    /** One line of the list. */
    struct Declaration
    {
      Path        home;    ///< the section it stands in; empty: the top level
      std::string name;    ///< of the section or entry
      Kind        kind;    ///< section, entry, or another name of one
      std::string pattern; ///< of an entry: the form in_words() reads
      std::string documentation; ///< of an entry
    };

    /** All that a handler has declared, in its order. */
    explicit DeclaredParameters(const dealii::ParameterHandler &prm);

    /**
     * The section, or the entry or its alias, of that name in @p home; null
     * if there is none.
     */
    const Declaration *
    find(const Path        &home,
         const std::string &name,
         const bool         is_section) const;

    /**
     * Whether there is such a section; the top level, {}, is one.
     */
    bool
    has_section(const Path &section) const;

    /**
     * What to do about a name that is not declared in @p home: the section it
     * belongs to, or else the nearest valid name; and what is known there.
     */
    std::string
    remedy_for_unknown(const Path        &home,
                       const std::string &name,
                       const bool         is_section) const;

  private:
    void
    collect(const boost::property_tree::ptree &tree, const Path &home);

    void
    add(const Declaration &declaration);

    std::vector<Declaration> declarations; // in the order they were made
    /** Place in declarations by home and name: of entries, of sections. */
    std::map<std::pair<Path, std::string>, std::size_t> entries, sections;
  };


  /**
   * A value as its entry's pattern reads it: the items of a list of numbers may
   * stand between commas or semicolons, whichever the pattern knows.
   *
   * @param pattern as for in_words()
   */
  std::string
  as_declared(const std::string &value, const std::string &pattern);

  /**
   * What a value must be, in words: "a number, at least 0", "one of MPM,
   * GIMP", "a list of 2 items separated by <,> or <;>, each a
   * number". A pattern
   * that has no words here is returned as it is.
   *
   * @param pattern a pattern's description for machines
   *   (dealii::Patterns::PatternBase::Machine)
   */
  std::string
  in_words(const std::string &pattern);
} // namespace emmy

#endif
