#ifndef emmy_output_animation_h
#define emmy_output_animation_h

#include <emmy/base/film_frame.h>
#include <emmy/base/surface.h>

#include <string>
#include <vector>

namespace emmy
{
  /**
   * Positions and one number of particles at several times, and surfaces
   * beside them, for a page that shows them as a film. Numbers have 16 bits
   * between the least and the largest of all frames, which is 1/65000 of the
   * scene. Frames are kept by who makes the film, so that a run that is
   * restarted goes on with them: 4 bytes a number, of at most 3000 particles
   * and as many lines.
   */
  class Animation
  {
  public:
    /**
     * @param label  of the number, with its unit
     * @param frames borrowed; those that there are already come first
     */
    Animation(const unsigned int      dim,
              const std::string      &label,
              std::vector<FilmFrame> &frames);

    /** A frame. Lines of surfaces are thinned out if they are very many. */
    template <int dim>
    void
    add(const double                           time,
        const std::vector<dealii::Point<dim>> &positions,
        const std::vector<double>             &values,
        const std::vector<Surface<dim>>       &surfaces);

    /**
     * A JSON object: dim, label, ranges (least and largest of each coordinate,
     * then of the number: its 1st to 99th percentile), line_ranges (of the
     * coordinates of lines), and frames, each with its time, extremes and
     * data: base64 of little-endian 16-bit numbers, particle by particle;
     * lines: the same of the ends of lines.
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
    const unsigned int      dim;
    const std::string       label;
    std::vector<FilmFrame> &frames;
  };
} // namespace emmy

#endif
