#include <emmy/grid/cell_work.h>
#include <emmy/transfer/rank_load.h>

#include <vector>

namespace emmy
{
  namespace
  {
    /** @param work,particles of this rank. Collective. */
    RankLoad
    over_mean(const double   work,
              const double   particles,
              const MPI_Comm communicator)
    {
      const auto all = dealii::Utilities::MPI::min_max_avg(
        std::vector<double>{work, particles}, communicator);
      const auto ratio = [](const dealii::Utilities::MPI::MinMaxAvg &of) {
        return of.avg > 0. ? of.max / of.avg : 1.;
      };
      return {ratio(all[0]), ratio(all[1])};
    }

    /** Work of the cells of this rank that hold no points. */
    template <int dim>
    double
    work_of_empty(const BackgroundGrid<dim> &grid, const std::size_t n_occupied)
    {
      return double(work_of_cell(0)) * (grid.n_owned_cells() - n_occupied);
    }
  } // namespace

  template <int dim>
  RankLoad
  load_of_ranks(const BackgroundGrid<dim>                     &grid,
                const dealii::Particles::ParticleHandler<dim> &particles)
  {
    double      work       = 0.;
    std::size_t n_occupied = 0;
    for (auto particle = particles.begin(); particle != particles.end();)
      {
        const auto   cell     = particle->get_surrounding_cell();
        unsigned int n_points = 0;
        for (; particle != particles.end() &&
               particle->get_surrounding_cell() == cell;
             ++particle)
          ++n_points;
        work += work_of_cell(n_points);
        ++n_occupied;
      }
    return over_mean(work + work_of_empty(grid, n_occupied),
                     particles.n_locally_owned_particles(),
                     grid.communicator());
  }

  template <int dim>
  RankLoad
  load_when_covered(const BackgroundGrid<dim> &grid)
  {
    double      work = 0., particles = 0.;
    std::size_t n_occupied = 0;
    for (const auto &[place, n_points] : grid.covered_here())
      {
        work += work_of_cell(n_points);
        particles += n_points;
        ++n_occupied;
      }
    return over_mean(work + work_of_empty(grid, n_occupied),
                     particles,
                     grid.communicator());
  }

#define INSTANTIATE(dim)                              \
  template RankLoad load_of_ranks<dim>(               \
    const BackgroundGrid<dim> &,                      \
    const dealii::Particles::ParticleHandler<dim> &); \
  template RankLoad load_when_covered<dim>(const BackgroundGrid<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
