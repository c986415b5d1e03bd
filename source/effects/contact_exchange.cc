#include <emmy/effects/contact_exchange.h>

#include <algorithm>

namespace emmy
{
  using namespace dealii::Utilities::MPI;
  using dealii::Tensor;
  /** Numbers for each rank, one list after the other. */
  using Message = std::vector<std::vector<double>>;

  namespace
  {
    template <int dim>
    std::vector<double>
    packed(const ContactParticle<dim> &particle)
    {
      std::vector<double> result{double(particle.id), double(particle.body)};
      for (unsigned int d = 0; d < dim; ++d)
        result.push_back(particle.place[d]);
      for (unsigned int i = 0; i < dim * dim; ++i)
        result.push_back(particle.F[i / dim][i % dim]);
      return result;
    }

    template <int dim>
    ContactParticle<dim>
    unpacked(const std::vector<double> &numbers, const unsigned int owner)
    {
      ContactParticle<dim> result;
      result.id    = numbers[0];
      result.body  = numbers[1];
      result.owner = owner;
      result.index = 0;
      for (unsigned int d = 0; d < dim; ++d)
        result.place[d] = numbers[2 + d];
      for (unsigned int i = 0; i < dim * dim; ++i)
        result.F[i / dim][i % dim] = numbers[2 + dim + i];
      return result;
    }

    template <int dim>
    using Corners = std::array<double, 2 * dim>;
  } // namespace

  template <int dim>
  std::vector<ContactParticle<dim>>
  with_those_near(const ContactRules<dim>          &rules,
                  std::vector<ContactParticle<dim>> mine,
                  const double                      margin,
                  const MPI_Comm                    communicator)
  {
    if (n_mpi_processes(communicator) == 1)
      return mine;
    constexpr double all = std::numeric_limits<double>::max();
    double           arm = 0.;
    Corners<dim>     box; // -lower, upper
    box.fill(-all);
    for (const ContactParticle<dim> &particle : mine)
      {
        arm = std::max(arm, particle.arm(rules.bodies[particle.body]));
        for (unsigned int d = 0; d < dim; ++d)
          {
            box[d]       = std::max(box[d], -particle.place[d]);
            box[dim + d] = std::max(box[dim + d], particle.place[d]);
          }
      }
    const double distance =
      rules.largest_reach() + margin + 2. * max(arm, communicator);
    const auto                      boxes = all_gather(communicator, box);
    const unsigned int              here  = this_mpi_process(communicator);
    std::map<unsigned int, Message> outgoing;
    for (const ContactParticle<dim> &particle : mine)
      for (unsigned int rank = 0; rank < boxes.size(); ++rank)
        {
          bool is_near = rank != here;
          for (unsigned int d = 0; d < dim; ++d)
            is_near = is_near &&
                      -particle.place[d] <= boxes[rank][d] + distance &&
                      particle.place[d] <= boxes[rank][dim + d] + distance;
          if (is_near)
            outgoing[rank].push_back(packed(particle));
        }
    for (const auto &[sender, message] : some_to_some(communicator, outgoing))
      for (const auto &numbers : message)
        mine.push_back(unpacked<dim>(numbers, sender));
    return mine;
  }

  template <int dim>
  void
  ContactExchange<dim>::begin(const Candidates<dim> &candidates,
                              const MPI_Comm         ranks)
  {
    communicator = ranks;
    asked_for.clear();
    told_to.clear();
    if (!is_needed())
      return;
    const unsigned int here = this_mpi_process(ranks);
    std::map<unsigned int, std::vector<std::uint64_t>> requests;
    const auto &particles = candidates.particles;
    for (unsigned int i = 0; i < particles.size(); ++i)
      if (particles[i].owner != here)
        {
          asked_for[particles[i].owner].push_back(i);
          requests[particles[i].owner].push_back(particles[i].id);
        }
    for (const auto &[rank, ids] : some_to_some(ranks, requests))
      for (const std::uint64_t id : ids)
        {
          const auto found =
            std::lower_bound(particles.begin(),
                             particles.end(),
                             id,
                             [](const auto &particle, const std::uint64_t i) {
                               return particle.id < i;
                             });
          // both ranks have found the same pairs
          AssertThrow(found != particles.end() && found->id == id &&
                        found->owner == here,
                      dealii::ExcInternalError());
          told_to[rank].push_back(found - particles.begin());
        }
  }

  template <int dim>
  void
  ContactExchange<dim>::operator()(
    std::vector<std::vector<double>> &numbers) const
  {
    if (!is_needed())
      return;
    std::map<unsigned int, Message> outgoing;
    for (const auto &[rank, own] : told_to)
      for (const unsigned int i : own)
        outgoing[rank].push_back(numbers[i]);
    for (auto &[rank, message] : some_to_some(*communicator, outgoing))
      {
        const auto &places = asked_for.at(rank);
        for (unsigned int i = 0; i < places.size(); ++i)
          numbers[places[i]] = message[i];
      }
  }

  namespace
  {
    /** Who keeps the springs of a particle for those who ask. */
    unsigned int
    keeper(const std::uint64_t id, const MPI_Comm communicator)
    {
      return id % n_mpi_processes(communicator);
    }
  } // namespace

  template <int dim>
  PairSprings<dim>
  ContactExchange<dim>::springs_of(const Candidates<dim>  &candidates,
                                   const PairSprings<dim> &springs) const
  {
    if (!is_needed())
      return springs;
    std::map<unsigned int, Message> to_keepers;
    for (const auto &[key, spring] : springs)
      {
        std::vector<double> numbers(key.begin(), key.end());
        for (unsigned int d = 0; d < dim; ++d)
          numbers.push_back(spring[d]);
        to_keepers[keeper(key[0], *communicator)].push_back(numbers);
      }
    std::map<std::pair<std::uint64_t, std::uint64_t>, Message> kept;
    for (const auto &[sender, message] :
         some_to_some(*communicator, to_keepers))
      {
        (void)sender;
        for (const auto &numbers : message)
          kept[{numbers[0], numbers[1]}].push_back(numbers);
      }
    std::map<unsigned int, std::vector<std::array<std::uint64_t, 2>>> requests;
    for (const ParticlePair &pair : candidates.pairs)
      {
        const std::uint64_t first = candidates.particles[pair.first].id;
        requests[keeper(first, *communicator)].push_back(
          {{first, candidates.particles[pair.second].id}});
      }
    std::map<unsigned int, Message> answers;
    for (const auto &[rank, pairs] : some_to_some(*communicator, requests))
      for (const auto &pair : pairs)
        if (const auto found = kept.find({pair[0], pair[1]});
            found != kept.end())
          answers[rank].insert(answers[rank].end(),
                               found->second.begin(),
                               found->second.end());
    PairSprings<dim> result;
    for (const auto &[rank, message] : some_to_some(*communicator, answers))
      {
        (void)rank;
        for (const auto &numbers : message)
          {
            PairKey key;
            std::copy_n(numbers.begin(), key.size(), key.begin());
            for (unsigned int d = 0; d < dim; ++d)
              result[key][d] = numbers[key.size() + d];
          }
      }
    return result;
  }

#define INSTANTIATE(dim)                                           \
  template std::vector<ContactParticle<dim>> with_those_near<dim>( \
    const ContactRules<dim> &,                                     \
    std::vector<ContactParticle<dim>>,                             \
    const double,                                                  \
    const MPI_Comm);                                               \
  template class ContactExchange<dim>;
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
