#ifndef emmy_run_catalogue_h
#define emmy_run_catalogue_h

#include <iosfwd>

namespace emmy
{
  /**
   * What a parameter file can name, one line each with what it is for:
   * effects, materials, shapes, shape functions, solvers. What a program
   * outside emmy added to the libraries is among them.
   */
  void
  print_catalogue(std::ostream &out);
} // namespace emmy

#endif
