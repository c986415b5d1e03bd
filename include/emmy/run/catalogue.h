#ifndef emmy_run_catalogue_h
#define emmy_run_catalogue_h

#include <iosfwd>
#include <string>

namespace emmy
{
  /**
   * What a parameter file can name, one line each with what it is for:
   * effects, materials, shapes, shape functions, solvers. What a program
   * outside emmy added to the libraries is among them.
   *
   * @param section prints only what entries of this section name, in lower or
   *   upper case; empty: all
   */
  void
  print_catalogue(std::ostream &out, const std::string &section = "");
} // namespace emmy

#endif
