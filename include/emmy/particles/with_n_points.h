#ifndef emmy_particles_with_n_points_h
#define emmy_particles_with_n_points_h

#include <type_traits>

namespace emmy
{
  /**
   * Call a function with the number of points of a group. With GIMP that is
   * often one, which it gets as a constant: loops over the points vanish then.
   */
  template <class Function>
  inline void
  with_n_points(const unsigned int n, const Function &function)
  {
    if (n == 1)
      function(std::integral_constant<unsigned int, 1>());
    else
      function(n);
  }
} // namespace emmy

#endif
