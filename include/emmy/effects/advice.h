#ifndef emmy_effects_advice_h
#define emmy_effects_advice_h

#include <deal.II/base/mpi.h>
#include <deal.II/base/point.h>

#include <string>
#include <vector>

namespace emmy
{
  /** What is known of a run before its first step. */
  template <int dim>
  struct BeforeTheRun
  {
    /** Of the boxes of this rank's particles, m. */
    std::vector<dealii::Point<dim>> corners;
    dealii::Point<dim>              lower, upper; ///< of the grid, m
    double                          end_time;     ///< s
    /** How far velocity and uniform accelerations let bodies fly, m. */
    double flight;
    /** Whether effects other than the one that is asked, and than uniform
     * accelerations, or fixed sides that move, may move bodies. */
    bool     is_moved_otherwise;
    MPI_Comm communicator; ///< of all ranks
  };

  /** What the parameters of an effect are, too, if they can say beforehand that
   * a scene is most likely not what was meant. */
  template <int dim>
  class Adviser
  {
  public:
    virtual ~Adviser() = default;

    /** Sentences for `emmy --check`, the same on all ranks. Collective. */
    virtual std::vector<std::string>
    advice(const BeforeTheRun<dim> &run) const = 0;
  };
} // namespace emmy

#endif
