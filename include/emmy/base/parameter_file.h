#ifndef emmy_base_parameter_file_h
#define emmy_base_parameter_file_h

#include <iosfwd>
#include <string>
#include <vector>

// Forward declaration
namespace dealii
{
  class ParameterHandler;
}

namespace emmy
{
  /**
   * The text of a parameter file, before dealii::ParameterHandler sees it.
   *
   * The names of a scene's bodies, materials, shapes and effects decide which
   * parameters exist. They are read here with value(), then the parameters
   * are declared, and parse() hands the text to the ParameterHandler. Errors
   * name file and line, what was written, and the nearest valid name.
   *
   * The syntax is that of ParameterHandler::parse_input():
   * @code
   *   include common.prm        # relative to this file, not to the shell
   *   subsection Materials
   *     set Names = rubber, \
   *                 steel
   *   end
   * @endcode
   * in lower or upper case. A # starts a comment wherever it stands. Lines
   * that end in a backslash are joined to the next one before comments are
   * removed: a comment that ends so swallows the next line, as in deal.II.
   * Here each file must close the sections it opens, and give an entry only
   * once. A file may override what it included earlier: the last one wins.
   *
   * Owned by the program's start; used once, before the scene is built. Reads
   * each file once and keeps a few strings per line.
   */
  class ParameterFile
  {
  public:
    /**
     * An empty file: every parameter keeps its default.
     */
    ParameterFile() = default;

    /**
     * Read @p filename and what it includes. Throws ExcRun, with file and
     * line, if a file cannot be read or includes itself, if a line is no
     * statement, an entry is given twice, or a section is left open.
     */
    explicit ParameterFile(const std::string &filename);

    /**
     * The same for text in memory. @p label stands for the file name in
     * messages; its directory is where included files are looked for.
     */
    static ParameterFile
    from_text(const std::string &text, const std::string &label);

    /**
     * Set one entry, overriding the file and earlier calls.
     *
     * @param assignment "Section/Subsection/Name=value", as on the command
     *   line after --set. Blanks around the names and the value do not count;
     *   the value may be empty and may contain further equal signs, but no #,
     *   which no parameter file could repeat. Throws ExcRun if malformed.
     * @param where what messages name as its origin
     */
    void
    set(const std::string &assignment, const std::string &where = "--set");

    /**
     * What stands in the file for one entry, or what set() put there.
     *
     * @param path          section names and entry name, separated by /
     * @param default_value returned if the entry is not given
     */
    std::string
    value(const std::string &path, const std::string &default_value) const;

    /** The entries of a section, as the file spells them. */
    std::vector<std::string>
    entries_of(const std::string &section) const;

    /**
     * Whether the section is opened anywhere, possibly without entries.
     *
     * @param path section names separated by /
     */
    bool
    has_section(const std::string &path) const;

    /**
     * Hand all entries to @p prm in their order, running its actions.
     *
     * Names come first: if some are not declared in @p prm, nothing is set
     * and one ExcRun lists every one of them with the nearest valid name, the
     * section it may belong to, and the names that are known there. Then the
     * values: one ExcRun lists all that @p prm does not accept, with what is
     * required in words and the entry's documentation.
     *
     * @pre @p prm stands at its top level; it does so again afterwards.
     */
    void
    parse(dealii::ParameterHandler &prm) const;

  private:
    /**
     * A set statement, or the opening of a section.
     */
    struct Statement
    {
      std::vector<std::string> section; // what it stands in
      std::string              name, value;
      std::string              where; // "FILE, line 12" or "--set"
      bool                     opens_section;
    };

    /**
     * Append the statements of one file.
     *
     * @param section the sections that are open where the file is included
     * @param files   the file itself, last, and those that include it
     */
    void
    read(std::istream                   &input,
         const std::vector<std::string> &section,
         const std::vector<std::string> &files);

    std::vector<Statement> statements;
  };
} // namespace emmy

#endif
