#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/run/output_parameters.h>

namespace emmy
{
  using dealii::Patterns::Anything;
  using dealii::Patterns::Double;
  using dealii::Patterns::Integer;
  using dealii::Patterns::List;

  OutputParameters::OutputParameters()
    : Section("Output")
  {
    add_parameter("Directory",
                  directory,
                  "Where the results go; created if it is not there.");
    add_parameter("Overwrite",
                  overwrite,
                  "Whether results of an earlier run in <Directory> may be "
                  "replaced. Also: --overwrite.");
    add_parameter("Frames",
                  frames,
                  "Number of equal parts of the run after each of which "
                  "particle and grid files are written. 0: none.",
                  prm,
                  Integer(0));
    add_parameter("Particle files",
                  particle_files,
                  "Whether frames have particle files (VTU).");
    add_parameter("Particle tables",
                  particle_tables,
                  "Whether frames have tables of the particles (CSV), with all "
                  "digits and all that another scene needs to begin with them: "
                  "Shape = particles.");
    add_parameter("Grid files",
                  grid_files,
                  "Whether frames have files of the active grid (VTU).");
    add_parameter("Particle fields",
                  particle_fields,
                  "What the particle files hold. carried: all that the "
                  "particles of the scene carry. Also one by one by their "
                  "names, as fields.txt has them: velocity, "
                  "equivalent_plastic_strain, ...; and what follows from "
                  "these: cauchy_stress (Pa), pressure (Pa), von_mises_stress "
                  "(Pa), logarithmic_strain, displacement (m; since the start "
                  "of the run; particles then carry where that was). Stresses "
                  "and strains are 3x3 tensors. A name that a scene does not "
                  "have is refused.",
                  prm,
                  List(Anything()));
    add_parameter("Pictures",
                  pictures,
                  "Whether pictures are drawn at the end, with gnuplot.");
    add_parameter("Report",
                  report,
                  "Whether report.html is written at the end: the scene, "
                  "curves of the ledger, where the time went, and the "
                  "particles of all frames, coloured by <Picture field>, as a "
                  "film. It opens in any browser, without a network.");
    add_parameter("Picture times",
                  picture_times,
                  "Times at which particles are drawn. Unit: s. Empty: the "
                  "start, the end, and four times between.",
                  prm,
                  List(Double()));
    add_parameter("Picture field",
                  picture_field,
                  "What the colours of the particles show: a scalar of "
                  "<Particle fields>, the length of a vector, or a component, "
                  "as velocity_x or cauchy_stress_yy. Colours range from the "
                  "1st to the 99th percentile of all particles drawn; the "
                  "extremes are printed beside them.");
  }

  void
  OutputParameters::validate() const
  {
    AssertThrow(!directory.empty(),
                ExcParameter(path(),
                             "Directory",
                             directory,
                             "it must name a folder, e.g. results/my-run."));
    for (const double time : picture_times)
      AssertThrow(time >= 0.,
                  ExcParameter(path(),
                               "Picture times",
                               shortest(time),
                               "times must not be negative (s)."));
  }
} // namespace emmy
