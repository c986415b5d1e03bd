#ifndef emmy_run_output_parameters_h
#define emmy_run_output_parameters_h

#include <emmy/base/section.h>

#include <string>
#include <vector>

namespace emmy
{
  /** Section `Output`. */
  class OutputParameters : public Section
  {
  public:
    std::string         directory      = "results";
    bool                overwrite      = false;
    unsigned int        frames         = 20;
    bool                particle_files = true, grid_files = true;
    bool                pictures = true, report = true;
    std::vector<double> picture_times; // s; empty: chosen by the run
    /** Of ParticleFields: what particle files hold, and what colours mean. */
    std::vector<std::string> particle_fields = {"carried",
                                                "cauchy_stress",
                                                "pressure",
                                                "von_mises_stress"};
    std::string              picture_field   = "strain_energy_density";

    OutputParameters();

    /** Throws ExcParameter. */
    void
    validate() const;
  };
} // namespace emmy

#endif
