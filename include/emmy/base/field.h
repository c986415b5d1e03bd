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

    /**
     * Of a field that particles carry less a constant, to keep the digits of
     * small numbers: the name under which the whole is written and told, and
     * the constant, one per component. Empty: as it is carried.
     */
    std::string         written_as   = {};
    std::vector<double> written_plus = {};

    const std::string &
    written_name() const
    {
      return written_as.empty() ? name : written_as;
    }

    /** The number to write for a component that is carried as @p value. */
    double
    written(const unsigned int component, const double value) const
    {
      return written_plus.empty() ? value : value + written_plus[component];
    }
  };
} // namespace emmy

#endif
