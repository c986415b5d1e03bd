#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/particles/particle_count.h>
#include <emmy/particles/particle_layout.h>

#include <algorithm>
#include <limits>

#include <unistd.h>

namespace emmy
{
  namespace
  {
    /** Bytes of all machines together that the ranks run on. Collective. */
    double
    memory_of_machines(const MPI_Comm communicator)
    {
      MPI_Comm of_machine;
      MPI_Comm_split_type(
        communicator, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &of_machine);
      const double n_ranks =
        dealii::Utilities::MPI::n_mpi_processes(of_machine);
      MPI_Comm_free(&of_machine);
      const double bytes =
        double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE));
      return dealii::Utilities::MPI::sum(bytes / n_ranks, communicator);
    }

    std::string
    gigabytes(const double bytes)
    {
      return brief(bytes / 1e9) + " GB";
    }

    template <int dim>
    double
    expected_particles(const Body<dim> &body, const BackgroundGrid<dim> &grid)
    {
      const auto box     = body.shape->bounding_box();
      const auto spacing = ParticleLayout<dim>(body, grid).spacing();
      double     in_grid = 1., one = 1.;
      for (unsigned int d = 0; d < dim; ++d)
        {
          one *= spacing[d];
          in_grid *=
            std::max(0.,
                     std::min(box.upper_bound(d), grid.upper_corner()[d]) -
                       std::max(box.lower_bound(d), grid.lower_corner()[d]));
        }
      const double volume = body.shape->volume();
      return (volume > 0. ? std::min(volume, in_grid) : in_grid) / one;
    }
  } // namespace

  template <int dim>
  void
  refuse_too_many(const std::vector<Body<dim>> &bodies,
                  const BackgroundGrid<dim>    &grid,
                  const FieldLayout            &layout)
  {
    double           all = 0., most = 0.;
    const Body<dim> *largest = nullptr;
    for (const Body<dim> &body : bodies)
      {
        const double n = expected_particles(body, grid);
        all += n;
        if (n > most)
          largest = &body;
        most = std::max(most, n);
      }
    // location and reference location, twice while they are made, id and cell
    const double bytes =
      all * (sizeof(double) * (3. * dim + layout.n_components()) + 64.);
    const double   memory = memory_of_machines(grid.communicator());
    constexpr auto most_ids =
      std::numeric_limits<dealii::types::particle_index>::max();
    std::string problem;
    if (all > most_ids)
      problem = "their ids end at " + std::to_string(most_ids);
    else if (bytes > memory)
      problem = "they take at least " + gigabytes(bytes) +
                ", and the machine has " + gigabytes(memory);
    if (!problem.empty())
      problem = "about " + brief(all) + " particles, " + brief(most) +
                " of them in body <" + largest->name + ">: " + problem;
    throw_together(grid.communicator(),
                   "Bodies",
                   problem,
                   "lower its Points per direction, or take larger cells "
                   "(Grid/Cells).");
  }

  template void
  refuse_too_many<2>(const std::vector<Body<2>> &,
                     const BackgroundGrid<2> &,
                     const FieldLayout &);
  template void
  refuse_too_many<3>(const std::vector<Body<3>> &,
                     const BackgroundGrid<3> &,
                     const FieldLayout &);
} // namespace emmy
