#ifndef emmy_base_film_frame_h
#define emmy_base_film_frame_h

#include <vector>

namespace emmy
{
  /** What the film of the report shows at a time. */
  struct FilmFrame
  {
    double time = 0.; ///< s
    /** Of each particle its place, m, and the number that is drawn. */
    std::vector<float> points;
    /** Lines of surfaces: the places of both ends, m, line by line. */
    std::vector<float> lines;
  };
} // namespace emmy

#endif
