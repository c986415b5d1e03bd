#ifndef emmy_output_animation_h
#define emmy_output_animation_h

#include <deal.II/base/point.h>

#include <string>
#include <utility>
#include <vector>

namespace emmy
{
  /**
   * Positions and one number of particles at several times, for a page that
   * shows them as a film. Numbers have 16 bits between the least and the
   * largest of all frames, which is 1/65000 of the scene. Frames are kept by
   * who makes the film, so that a run that is restarted goes on with them: 4
   * bytes a number, of at most 3000 particles.
   */
  class Animation
  {
  public:
    /** Of each frame: its time, s; then dim + 1 numbers a particle. */
    using Frames = std::vector<std::pair<double, std::vector<float>>>;

    /**
     * @param label  of the number, with its unit
     * @param frames borrowed; those that there are already come first
     */
    Animation(const unsigned int dim, const std::string &label, Frames &frames);

    /** A frame of this rank's particles. Collective. */
    template <int dim>
    void
    add(const double                           time,
        const std::vector<dealii::Point<dim>> &positions,
        const std::vector<double>             &values);

    /**
     * A JSON object: dim, label, ranges (least and largest of each coordinate,
     * then of the number: its 1st to 99th percentile), and frames, each with
     * its time, extremes and data: base64 of little-endian 16-bit numbers,
     * particle by particle.
     */
    std::string
    json() const;

    /** So far. */
    unsigned int
    n_frames() const
    {
      return frames.size();
    }

  private:
    const unsigned int dim;
    const std::string  label;
    Frames            &frames;
  };
} // namespace emmy

#endif
