#ifndef emmy_step_run_state_h
#define emmy_step_run_state_h

#include <deal.II/particles/particle_handler.h>

#include <emmy/base/film_frame.h>
#include <emmy/effects/step_report.h>
#include <emmy/solve/linear_solver.h>

#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /** What the detector has seen so far. */
  struct DetectorState
  {
    double largest_kinetic_energy = 0.; ///< J
    /** J. */
    double stored_energy = 0., largest_stored = 0.;
    double overfill_at_start = 0.; ///< of the first step
    /** Steps on end beyond the bounds: of both, of each alone. */
    unsigned int n_both = 0, n_hidden = 0, n_overfilled = 0;
  };

  /** What has been written of a run. */
  struct FramesState
  {
    /** Written so far. */
    unsigned int n_intervals = 0, n_frames = 0, n_pictures = 0;
    /** Times, s. */
    double last_frame = -1., last_picture = -1.;
    double reached = 0.; ///< pictures up to this time were due, s
    /** Time (s) and file of each frame. */
    std::vector<std::pair<double, std::string>> particle_files, grid_files,
      surface_files;
    /** On rank 0: see Pictures::memory(). */
    std::vector<double> pictures;
    /** On rank 0: what the film of the report shows, and so far. */
    std::string film_label;
    /** Its pictures. */
    std::vector<FilmFrame> film;
  };

  /** How often steps were hard to make. */
  struct Struggles
  {
    unsigned int halvings = 0; ///< how often a step was tried again
    unsigned int damped   = 0; ///< steps that needed a damped Newton matrix
  };

  /** What has been said on the screen, and is not said again. */
  struct Told
  {
    /** What the log has told. */
    bool limited_travel = false, struggled = false, held_places = false,
         detected = false, crossed_cells = false;
    std::uint64_t most_cut_domains = 0; ///< in a step so far
  };

  /**
   * What one step hands to the next: from this, what effects and measurements
   * remember (Effect::memory(), Measurement::memory()) and the parameters a run
   * can go on. Steppers, ledger and frames keep what can be made again. Owned
   * by the scene. What is added here is added to run/saved_run.cc, which does
   * not compile without it.
   */
  template <int dim>
  struct RunState
  {
    dealii::Particles::ParticleHandler<dim> particles; ///< all of this rank
    unsigned int                            step = 0; ///< the last accepted one
    double                                  time = 0.; ///< s
    double kinetic_energy = 0.; ///< of the particles, in the ledger's last row
    DetectorState detector;     ///< of the detector of noise
    LedgerSums    ledger;       ///< over the steps so far
    FramesState   frames;       ///< of files and pictures
    /** Of a run at its end: without what is written there only; else empty. */
    std::vector<FramesState> frames_before_end;
    Told                     told;          ///< what the log has told
    Struggles                struggles;     ///< halved and damped steps
    LinearSolverState        linear_solver; ///< what solvers remember
    /** The next increment of static steps, s; 0: the usual one. */
    double increment = 0.;
    /** A number that tells in which cells particles were at the start. */
    std::uint64_t occupancy_at_start = 0;
  };
} // namespace emmy

#endif
