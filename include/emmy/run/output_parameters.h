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
    std::string directory = "results"; ///< where results go
    /** Whether results that are there may go. */
    bool overwrite = false;
    /** Of pictures and files, over the run. */
    unsigned int frames = 20;
    /** Whether VTU files are written. */
    bool particle_files = true, grid_files = true;
    bool particle_tables = false; ///< and whether CSV
    /** Whether they are drawn. */
    bool                pictures = true, report = true;
    std::vector<double> picture_times; ///< s; empty: chosen by the run
    /** Of ParticleFields: what particle files hold, and what colours mean. */
    std::vector<std::string> particle_fields = {"carried",
                                                "cauchy_stress",
                                                "pressure",
                                                "von_mises_stress"};
    /** By which pictures are coloured. */
    std::string picture_field = "strain_energy_density";

    OutputParameters();

    /** Throws ExcParameter. */
    void
    validate() const;
  };
} // namespace emmy

#endif
