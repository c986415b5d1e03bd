#ifndef emmy_effects_load_ramp_h
#define emmy_effects_load_ramp_h

#include <string>
#include <vector>

namespace emmy
{
  /** How much of the loads acts. */
  struct LoadRamp
  {
    double                   factor = 1.; ///< of all loads that it names
    std::vector<std::string> names; ///< effects that it is for; empty: all

    /** By which an effect's load is multiplied. */
    double
    factor_of(const std::string &effect) const
    {
      for (const std::string &name : names)
        if (name == effect)
          return factor;
      return names.empty() ? factor : 1.;
    }
  };
} // namespace emmy

#endif
