#ifndef emmy_run_failure_bundle_h
#define emmy_run_failure_bundle_h

#include <emmy/output/run_directory.h>
#include <emmy/run/scene.h>

#include <string>

namespace emmy
{
  /**
   * What a step leaves that could not be made, in the folder `failure` of the
   * results: the checkpoint before it, the parameters, the ledger, and
   * cause.txt with the cause in words, the weakest nodes, and the residuals of
   * all tries. `emmy --restart RESULTS/failure` repeats the step. Collective.
   *
   * @param parameters of the run, as a parameter file
   * @param cause      what the step said when it gave up
   * @return what went wrong with the files, the same on all ranks; or empty
   */
  template <int dim>
  std::string
  write_failure_bundle(Scene<dim>         &scene,
                       const std::string  &parameters,
                       const RunDirectory &directory,
                       const std::string  &cause);
} // namespace emmy

#endif
