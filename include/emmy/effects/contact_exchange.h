#ifndef emmy_effects_contact_exchange_h
#define emmy_effects_contact_exchange_h

#include <emmy/effects/contact_search.h>

#include <map>
#include <optional>

namespace emmy
{
  /** Two contact points: ids of the particles, and which of their points. */
  using PairKey = std::array<std::uint64_t, 4>;

  /** What sticks two contact points to one another, by both. */
  template <int dim>
  using PairSprings = std::map<PairKey, dealii::Tensor<1, dim>>;

  /**
   * The particles of this rank, and those of others that may be as near to one
   * of them as the largest reach and a margin. Cost: the boxes around the
   * particles of each rank go to all; particles to those whose boxes they are
   * near. Collective.
   */
  template <int dim>
  std::vector<ContactParticle<dim>>
  with_those_near(const ContactRules<dim>          &rules,
                  std::vector<ContactParticle<dim>> mine,
                  const double                      margin,
                  const MPI_Comm                    communicator);

  /** Tells ranks of candidates that others own. */
  template <int dim>
  class ContactExchange
  {
  public:
    /** Ask the owners for those of other ranks. Collective. */
    void
    begin(const Candidates<dim> &candidates, const MPI_Comm communicator);

    /**
     * Numbers of each candidate: those of own ones are told to who asked for
     * them, those of others are filled in. Collective.
     */
    void
    operator()(std::vector<std::vector<double>> &numbers) const;

    /**
     * What sticks the candidates of this rank.
     * @param springs each on one rank, whichever
     */
    PairSprings<dim>
    springs_of(const Candidates<dim>  &candidates,
               const PairSprings<dim> &springs) const;

    /** Whether there are other ranks. */
    bool
    is_needed() const
    {
      return communicator &&
             dealii::Utilities::MPI::n_mpi_processes(*communicator) > 1;
    }

  private:
    std::optional<MPI_Comm> communicator;
    /** By rank, candidates in the order of their ids. */
    std::map<unsigned int, std::vector<unsigned int>> asked_for, told_to;
  };
} // namespace emmy

#endif
