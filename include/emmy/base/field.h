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
    /** Number of components: scalar, vector, symmetric tensor or tensor. */
    enum class Kind
    {
      scalar,
      vector,           ///< dim components
      symmetric_tensor, ///< n_mandel<dim> components in Mandel notation
      tensor            ///< dim x dim components by rows; 33 is 1 in 2D
    };

    std::string name;        ///< with which code asks for it
    Kind        kind;        ///< what it has per particle
    std::string unit;        ///< SI, for the header of files
    std::string description; ///< for `fields.txt`
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
    std::string written_as = {};
    /**
     * Added to each component where it is written, e.g. 1 on the diagonal of b
     * - I.
     */
    std::vector<double> written_plus = {};

    /** The name in files: that of what is written. */
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
