#ifndef emmy_effects_contact_search_h
#define emmy_effects_contact_search_h

#include <emmy/effects/contact_pair.h>
#include <emmy/particles/stencils.h>

#include <limits>
#include <vector>

namespace emmy
{
  /** What the particles of a body are to those of other groups. */
  template <int dim>
  struct ContactBody
  {
    /** No particle. */
    static constexpr unsigned int none =
      std::numeric_limits<unsigned int>::max();

    dealii::Tensor<1, dim> half_length; ///< of the box at the start, m
    double                 spacing;     ///< s, m
    double                 modulus;     ///< M of P-waves, Pa
    unsigned int           group;       ///< none: touches nothing
  };

  /** The law of contact between bodies, before it knows which. */
  template <int dim>
  struct ContactRules
  {
    std::vector<ContactBody<dim>> bodies; ///< all, with their groups
    double       radius;   ///< R: the reach over the spacing of contact points
    unsigned int exponent; ///< q
    unsigned int points_per_direction; ///< n
    double       stiffness;            ///< beta
    double       friction;             ///< mu
    double       spring_stiffness;     ///< k_T/k

    /** Of this rank and copies of others'. */
    unsigned int
    n_points() const
    {
      return dealii::Utilities::pow(points_per_direction, dim);
    }

    /** xi of a contact point: its place in the undeformed box, m. */
    dealii::Tensor<1, dim>
    point(const unsigned int body, unsigned int index) const;

    /**
     * Of points of two bodies: with the spacing s_c of contact points, the mean
     * of both, and the harmonic mean M of the moduli, k = beta M s_c^(dim-2)
     * and rho = R s_c.
     */
    PairLaw
    law(const unsigned int first, const unsigned int second) const;

    /** rho of points of two bodies, m. */
    double
    reach(const unsigned int first, const unsigned int second) const
    {
      return radius * 0.5 * (bodies[first].spacing + bodies[second].spacing) /
             points_per_direction;
    }

    /** The largest rho of any two bodies, m. */
    double
    largest_reach() const;
  };

  /** A particle whose body is in a group. */
  template <int dim>
  struct ContactParticle
  {
    dealii::types::particle_index id;    ///< over all ranks
    unsigned int                  body;  ///< its body's number
    unsigned int                  owner; ///< its rank
    std::size_t                   index; ///< there, among the places
    dealii::Point<dim>            place; ///< at t, m
    dealii::Tensor<2, dim>        F;     ///< at t

    /** How far its contact points are from it at most, m. */
    double
    arm(const ContactBody<dim> &of_body) const;
  };

  /** Two particles of different groups; the first has the smaller id. */
  struct ParticlePair
  {
    /** Numbers among the particles. */
    unsigned int first, second;
    /** Their contact points that may touch. */
    std::vector<std::array<unsigned char, 2>> points;
  };

  /** What may touch within a step. */
  template <int dim>
  struct Candidates
  {
    std::vector<ContactParticle<dim>> particles; ///< sorted by id
    std::vector<ParticlePair>         pairs;     ///< sorted by both ids
  };

  /**
   * All pairs of contact points of different groups that are nearer to one
   * another than their reach and a margin, one of them at least a rank's own,
   * with their particles. Cost: a tree
   * of the particles where the boxes around groups meet (boost's R-tree), a
   * query for each.
   */
  template <int dim>
  Candidates<dim>
  find_candidates(const ContactRules<dim>                 &rules,
                  const std::vector<ContactParticle<dim>> &particles,
                  const double                             margin,
                  const unsigned int                       rank);
} // namespace emmy

#endif
