#ifndef emmy_base_section_h
#define emmy_base_section_h

#include <deal.II/base/parameter_acceptor.h>

#include <string>

namespace emmy
{
  /**
   * Base of every struct of parameters: a ParameterAcceptor whose section is
   * given by its full path, e.g. "Materials/rubber", whatever was declared
   * before it.
   */
  class Section : public dealii::ParameterAcceptor
  {
  public:
    /** A section of a parameter file, e.g. "Effects/Gravity". */
    explicit Section(const std::string &path)
      : dealii::ParameterAcceptor("/" + path)
      , full_path(path)
    {}

    /** The section's path, for messages. */
    const std::string &
    path() const
    {
      return full_path;
    }

  private:
    const std::string full_path;
  };
} // namespace emmy

#endif
