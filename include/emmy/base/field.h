#ifndef emmy_base_field_h
#define emmy_base_field_h

#include <string>
#include <vector>

namespace emmy
{
  /**
   * A quantity that each particle carries. Effects and materials name the
   * fields that they need; the particles' layout is their union.
   */
  struct Field
  {
    enum class Kind
    {
      scalar,
      vector,           ///< dim components
      symmetric_tensor, ///< n_mandel<dim> components in Mandel notation
      tensor            ///< dim x dim components by rows; 33 is 1 in 2D
    };

    std::string name;
    Kind        kind;
    std::string unit;
    std::string description;
    /** Components of an undisturbed particle; empty: all zero. */
    std::vector<double> initial      = {};
    unsigned int        n_components = 0; ///< set by the layout
    unsigned int        offset       = 0; ///< set by the layout
    /** The effect that asked first; set by the layout. */
    std::string asked_by = {};
  };
} // namespace emmy

#endif
