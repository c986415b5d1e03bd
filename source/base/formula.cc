#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>

#include <iostream>
#include <map>

namespace emmy
{
  namespace
  {
    /** Keeps std::cerr quiet while it exists. */
    class Silence
    {
    public:
      Silence()
        : screen(std::cerr.rdbuf(nullptr))
      {}

      ~Silence()
      {
        std::cerr.rdbuf(screen);
      }

      Silence(const Silence &) = delete;
      Silence &
      operator=(const Silence &) = delete;

    private:
      std::streambuf *const screen;
    };


    /** What muParser said about a formula; empty if it said nothing. */
    std::string
    complaint(const dealii::ExceptionBase &error)
    {
      const std::string key  = "The parser said: ";
      const std::string text = message_of(error);
      const std::size_t said = text.find(key);
      return said == std::string::npos
               ? std::string()
               : dealii::Utilities::trim(text.substr(said + key.size()));
    }
  } // namespace


  std::string
  separated_by(const char separator, std::string list)
  {
    int depth = 0; // of parentheses
    for (char &letter : list)
      {
        depth += (letter == '(') - (letter == ')');
        if (depth == 0 && (letter == ',' || letter == ';'))
          letter = separator;
      }
    return list;
  }


  template <int dim>
  std::unique_ptr<dealii::FunctionParser<dim>>
  read_formulas(const std::string &text,
                const unsigned int n_components,
                const std::string &section,
                const std::string &entry,
                const std::string &remedy,
                const std::string &variables)
  {
    auto function = std::make_unique<dealii::FunctionParser<dim>>(n_components);
    // what deal.II prints on every rank is part of the message below
    const Silence silence;
    try
      {
        function->initialize(variables,
                             separated_by(';', text),
                             std::map<std::string, double>{
                               {"pi", dealii::numbers::PI}});
        function->value(dealii::Point<dim>()); // only now it is parsed
      }
    catch (const dealii::ExceptionBase &error)
      {
        const std::string said = complaint(error);
        AssertThrow(false,
                    ExcParameter(section,
                                 entry,
                                 text,
                                 "it cannot be read" +
                                   (said.empty() ? "" : " (" + said + ")") +
                                   ". " + remedy));
      }
    return function;
  }

#define INSTANTIATE(dim)                                                    \
  template std::unique_ptr<dealii::FunctionParser<dim>> read_formulas<dim>( \
    const std::string &,                                                    \
    const unsigned int,                                                     \
    const std::string &,                                                    \
    const std::string &,                                                    \
    const std::string &,                                                    \
    const std::string &);
  INSTANTIATE(1)
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
