#ifndef emmy_run_start_h
#define emmy_run_start_h

#include <emmy/base/section.h>
#include <emmy/grid/background_grid.h>
#include <emmy/output/run_directory.h>
#include <emmy/particles/body.h>
#include <emmy/particles/field_layout.h>

#include <map>
#include <string>
#include <vector>

namespace emmy
{
  /** Section `Start`. */
  class StartParameters : public Section
  {
  public:
    std::string  from;     ///< results of a run; empty: bodies are filled
    unsigned int step = 0; ///< 0: the last

    StartParameters();

    /** Throws ExcParameter if the run would replace what it starts from. */
    void
    validate(const std::string &output_directory) const;
  };

  /** What a scene takes over from another run besides particles. */
  struct StartedFrom
  {
    std::string                   path;   ///< of the checkpoint; empty: none
    std::map<std::string, double> stored; ///< energies by ledger column, J
    std::vector<std::string>      notes;  ///< for the log
    /** Whether set_cell_states() is to find what the old run had not. */
    bool lacks_cell_states = false;
  };

  /**
   * Fill a scene with the particles of a run, instead of with those of its
   * bodies. Fields that the run had keep their values, others get those of a
   * virgin body; so do those that effects ask for, who choose their particles
   * anew. Chooses the grid's window. Collective. Throws ExcRun on all ranks
   * if the run has other bodies or dimensions, or a particle is outside of the
   * grid.
   *
   * @param effects names of those of the scene
   */
  template <int dim>
  StartedFrom
  start_from(const StartParameters                   &parameters,
             const std::vector<Body<dim>>            &bodies,
             const std::vector<std::string>          &effects,
             const FieldLayout                       &layout,
             BackgroundGrid<dim>                     &grid,
             dealii::Particles::ParticleHandler<dim> &particles);

  /**
   * Keep a copy of the checkpoint in the folder `start` of the results, from
   * which the run is restarted. Throws ExcRun on all ranks. Collective.
   */
  void
  keep_start(const StartedFrom  &started,
             const RunDirectory &directory,
             const MPI_Comm      communicator);
} // namespace emmy

#endif
