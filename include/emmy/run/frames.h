#ifndef emmy_run_frames_h
#define emmy_run_frames_h

#include <emmy/output/animation.h>
#include <emmy/output/pictures.h>
#include <emmy/output/run_directory.h>
#include <emmy/output/series.h>
#include <emmy/run/scene.h>

#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * Writes particle and grid files at the times that the parameters ask for,
   * and collects what the pictures show. Owned by the run. Cost: a pass over
   * the particles per frame.
   */
  template <int dim>
  class Frames
  {
  public:
    /** Borrows all three. */
    Frames(Scene<dim>                 &scene,
           const SceneParameters<dim> &parameters,
           const RunDirectory         &directory);

    /** The state before the first step. Collective. */
    void
    initial();

    /**
     * Instead of initial(): go on with the state of the run. Files of frames
     * after it are removed; so is what is written at the end only, if this
     * is no longer the end. Collective.
     */
    void
    go_on(const bool is_at_end);

    /** After the last step: its state, if it is not there yet. Collective. */
    void
    at_end(const StepReport &last);

    /** After an accepted step: whatever became due. Collective. */
    void
    after(const StepReport &report);

    /**
     * What at_end() writes, then the pictures. Collective.
     *
     * @param last        the last accepted step
     * @param is_complete no step failed after it; after one that did, the
     *   grid is that of the failed step and is not written
     * @return warnings, one line each
     */
    std::vector<std::string>
    finish(const StepReport &last, const bool is_complete);

    /** What a report shows of the frames; on the first rank, if wanted. */
    const Animation *
    film() const
    {
      return animation.get();
    }

  private:
    /** How many of the wanted equal parts of the run have passed. */
    unsigned int
    intervals_until(const double time) const;
    void
    write_last(const StepReport &last, const bool is_complete);
    void
    write_files(const double time, const bool with_grid);
    void
    write_particles(const double time);
    void
    write_grid(const double time);
    void
    write_surfaces(const double time);
    void
    take_picture(const double time);
    /** Particles of the picture field, thinned out, on the first rank. */
    struct Drawn
    {
      std::vector<dealii::Point<dim>> positions;
      std::vector<double>             values;
    };
    Drawn
    gather_drawn(const std::size_t most) const;
    /** What is shown beside the particles. */
    std::vector<Surface<dim>>
    surfaces(const double time) const;

    Scene<dim>  &scene;
    FramesState &state;
    bool         has_grid = false; ///< of a step: not before the first here
    const OutputParameters    &wanted;
    const double               end_time;
    const RunDirectory        &directory;
    const MPI_Comm             communicator;
    const bool                 is_first;
    std::unique_ptr<Pictures>  pictures;  // none unless wanted
    std::unique_ptr<Animation> animation; // the same
    Series                     particle_series, grid_series, surface_series;
    std::vector<double>        picture_times;
  };
} // namespace emmy

#endif
