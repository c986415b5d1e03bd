#include <emmy/base/exceptions.h>
#include <emmy/particles/nearest.h>

#include <limits>

namespace emmy
{
  template <int dim>
  NearestParticles<dim>::NearestParticles(
    const Positions                               &positions,
    const std::string                             &section,
    const std::string                             &entry,
    const BackgroundGrid<dim>                     &grid,
    const dealii::Particles::ParticleHandler<dim> &particles,
    const Filter                                  &counts)
    : positions(positions)
    , tolerance(1e-9 * grid.shortest_side())
    , communicator(grid.communicator())
    , lengths(positions.size(), std::numeric_limits<double>::infinity())
  {
    for (const auto &position : positions)
      AssertThrow(grid.contains(position),
                  ExcParameter(section,
                               entry,
                               dealii::Patterns::Tools::to_string(position),
                               "this position is outside the grid. Give "
                               "positions at the body as it is at the start, "
                               "in m."));
    for (const auto &particle : particles)
      if (!counts || counts(particle))
        for (unsigned int i = 0; i < positions.size(); ++i)
          lengths[i] = std::min(lengths[i],
                                positions[i].distance(particle.get_location()));
    dealii::Utilities::MPI::min(lengths, grid.communicator(), lengths);
  }

  template <int dim>
  bool
  NearestParticles<dim>::is_nearest(const unsigned int        i,
                                    const dealii::Point<dim> &place) const
  {
    return positions[i].distance(place) <= lengths[i] + tolerance;
  }

  template <int dim>
  const std::vector<double> &
  NearestParticles<dim>::distances() const
  {
    return lengths;
  }

  template <int dim>
  std::vector<unsigned int>
  NearestParticles<dim>::numbers(
    const dealii::Particles::ParticleHandler<dim> &particles) const
  {
    std::vector<unsigned int> result(positions.size());
    for (const auto &particle : particles)
      for (unsigned int i = 0; i < positions.size(); ++i)
        result[i] += is_nearest(i, particle.get_location());
    dealii::Utilities::MPI::sum(result, communicator, result);
    return result;
  }

  template class NearestParticles<2>;
  template class NearestParticles<3>;
} // namespace emmy
