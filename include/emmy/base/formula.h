#ifndef emmy_base_formula_h
#define emmy_base_formula_h

#include <deal.II/base/function_parser.h>

#include <memory>
#include <string>

namespace emmy
{
  /**
   * A list whose items stand between commas or semicolons, written with
   * @p separator between them. Those in parentheses, as of the function
   * min(x, y), separate nothing.
   */
  std::string
  separated_by(const char separator, std::string list);

  /**
   * Read formulas of a parameter: functions of the position x, y (and z), or
   * of other variables, separated by , or ;, that may use pi. Throws
   * ExcParameter for @p section and @p entry with the parser's complaint and
   * @p remedy.
   *
   * @param n_components how many formulas there must be
   * @param remedy       what is expected, e.g. "Write 2 components, ..."
   * @param variables    dim names separated by commas, e.g. "t" with dim = 1
   */
  template <int dim>
  std::unique_ptr<dealii::FunctionParser<dim>>
  read_formulas(const std::string &text,
                const unsigned int n_components,
                const std::string &section,
                const std::string &entry,
                const std::string &remedy,
                const std::string &variables =
                  dealii::FunctionParser<dim>::default_variable_names());
} // namespace emmy

#endif
