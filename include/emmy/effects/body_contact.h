#ifndef emmy_effects_body_contact_h
#define emmy_effects_body_contact_h

#include <emmy/effects/contact_exchange.h>
#include <emmy/effects/corner_forces.h>

namespace emmy
{
  /**
   * Contact between groups of bodies, that have a velocity field each. The
   * particles have contact points y = x_p + a at even places of their boxes,
   * a = F_p xi, which move with them as the corners do that tools push (see
   * Tools): so no force jumps between steps. Points of two groups repel one
   * another as pair_action() says.
   *
   * Candidates, all points that are nearer than their reach and a margin, are
   * found once in a step. A pair that is left out must be apart at the end too:
   * if the bodies have moved by more than the margin, missing() says so, and
   * the step is solved again with a larger one.
   *
   * Nodes are coupled only by pairs of particles that touch, or nearly: where
   * the grid is undeformed in the middle of the step, the stencils tell where
   * the last iterate leads. A pair that touches against that estimate has its
   * derivative from the next iteration on.
   *
   * Cost: a search in each step; in each evaluation a sweep over the particles,
   * as for tools, some products for each candidate, and for each pair of
   * particles that touch a matrix of the nodes of both.
   */
  template <int dim>
  class BodyContact : public Effect<dim>,
                      public NodeCoupling<dim>,
                      public StepMemory,
                      public StepMeasures<dim>
  {
  public:
    /** Numbers of the fields that it reads. */
    struct Fields
    {
      /** Where a particle's body, and its F, are among its numbers. */
      unsigned int body, deformation_gradient;
    };

    /**
     * @param group_names of the groups, for columns of the ledger
     * @param corners_of_body those of the particles of each body
     */
    BodyContact(ContactRules<dim>                 rules,
                std::vector<std::string>          group_names,
                const Fields                     &fields,
                std::vector<ParticleCorners<dim>> corners_of_body);

    /** Tells of overlaps. */
    std::string
    mark(const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const override;

    /** How far was looked, and what sticks. */
    StepMemory *
    memory() override
    {
      return this;
    }
    std::vector<double>
    contents() const override;
    void
    recall(const std::vector<std::vector<double>> &parts) override;

    NodeCoupling<dim> *
    coupling() override
    {
      return this;
    }
    void
    classify(const Stencils<dim>       &stencils,
             const PointArrays<dim>    &points,
             const BackgroundGrid<dim> &grid) override;
    bool
    couples_by_weights() const override
    {
      return true;
    }
    void
    couple(const Stencils<dim>           &stencils,
           const BackgroundGrid<dim>     &grid,
           const BoundaryConditions<dim> &boundary_conditions,
           Couplings<dim>                &couplings) override;
    bool
    take_weights(const Stencils<dim>       &stencils,
                 const BackgroundGrid<dim> &grid) override;
    std::string
    missing(const StepData<dim> &step, const Vector &displacement) override;
    /** F of all particles. */
    void
    follow(const Stencils<dim>       &stencils,
           const PointArrays<dim>    &points,
           const ActiveGrid<dim>     &active,
           const std::vector<double> &displacement,
           PointArrays<dim>          &trial) const override;
    void
    end_step(const double time, const double time_step) override;

    bool
    is_force() const override
    {
      return true;
    }
    bool
    has_kinks() const override
    {
      return has_friction() || rules.exponent == 2;
    }
    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;

    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;
    /** What overlaps has been stored, and put in by who made the scene. */
    std::vector<EnergyEntry>
    energies_at_start(const PointArrays<dim> &points,
                      const double            time) const override;

    StepMeasures<dim> *
    measures() override
    {
      return this;
    }
    /** Forces on the groups in the last step, and how many pairs touched. */
    std::vector<StepMeasure>
    measure(const PointArrays<dim>    &points,
            const double               time,
            const BackgroundGrid<dim> &grid) override;

    /** Names of the columns that enter no balance. */
    static std::vector<std::string>
    columns_of(const std::vector<std::string> &group_names);

  private:
    using Group    = typename Stencils<dim>::Group;
    using ByMotion = std::array<PointMotion<dim>, dim *(dim + 1)>;
    using NodeIds  = std::vector<dealii::types::global_dof_index>;
    static constexpr unsigned int n_motion = dim * (dim + 1);

    /** Where a candidate stands in the stencils of now. */
    struct Where
    {
      unsigned int        group, point; ///< of this rank; else none
      unsigned int        nodes;        ///< among all lists of nodes
      dealii::Point<dim>  place;        ///< that of the stencils, m
      NodeIds             ids;
      std::vector<double> weights; ///< W: S, grad S, [(dim + 1) a + l]

      unsigned int
      n_nodes() const
      {
        return ids.size();
      }
    };
    /** Pairs of particles whose nodes are those of two lists. */
    struct Clique
    {
      std::array<unsigned int, 2> lists; ///< of the first and second particles
      std::vector<unsigned int>   pairs;
      std::size_t                 coupled = 0; ///< in Couplings::node_ids
    };
    /** The candidates in an evaluation. */
    struct States
    {
      std::vector<CornerMotion<dim>>      motions;
      std::vector<dealii::Tensor<1, dim>> ways; ///< of their points, m
    };
    /** Derivatives of pairs of particles that act on one another. */
    struct PairMatrices
    {
      std::vector<unsigned int>        of_pair; ///< by candidate; or none
      std::vector<PairDerivative<dim>> matrices;
    };

    bool
    has_friction() const
    {
      return rules.friction > 0.;
    }
    /** Those that this rank owns. */
    std::vector<ContactParticle<dim>>
    in_groups(const Stencils<dim>    &stencils,
              const PointArrays<dim> &points,
              const unsigned int      rank) const;
    /** Its contact points xi, by body. */
    static std::vector<std::vector<dealii::Tensor<1, dim>>>
    contact_points(const ContactRules<dim> &rules);
    /** Whether the nodes of one candidate come before those of another. */
    bool
    is_before(const unsigned int one, const unsigned int other) const
    {
      return where[one].ids < where[other].ids;
    }
    /** Number the lists of nodes. */
    void
    number_nodes();
    /** Of what couples. */
    std::vector<Clique>
    cliques_now() const;
    CornerMotion<dim>
    particle(const StepData<dim>       &step,
             const Group               &group,
             const unsigned int         q,
             const std::vector<double> &local_displacement) const;
    void
    find_where(const Stencils<dim> &stencils, const BackgroundGrid<dim> &grid);
    /** W and places of candidates whose nodes are known. */
    void
    renew_weights(const Stencils<dim>       &stencils,
                  const BackgroundGrid<dim> &grid);
    /** Whether two particles touch in the step, or nearly, as places say. */
    bool
    nearly_touch(const ParticlePair &pair) const;
    /** Note which pairs of particles couple their nodes. */
    void
    find_coupled(const bool at_middle);
    /** Nodes of candidates that other ranks own, and whom they follow. */
    void
    exchange_nodes(const BackgroundGrid<dim> &grid, Couplings<dim> &couplings);
    bool
    is_mine(const unsigned int candidate) const
    {
      return where[candidate].group != ContactBody<dim>::none;
    }
    /** Of a candidate that is mine, by its weights. */
    CornerMotion<dim>
    motion_of(const unsigned int         candidate,
              const StepData<dim>       &step,
              const std::vector<double> &local_displacement) const;
    /** The candidates as they move. Collective. */
    States
    states(const StepData<dim>       &step,
           const std::vector<double> &local_displacement) const;
    /**
     * Call visit(pair, key, action) for what acts, also for a moment.
     * @param derivatives of pairs, which are added to; null: not wanted
     */
    template <class Visit>
    void
    for_each_action(const States       &states,
                    PairMatrices *const derivatives,
                    const Visit        &visit) const;
    PairPoint<dim>
    point(const States      &states,
          const unsigned int candidate,
          const unsigned int index) const;
    /** Tell other ranks of the candidates that act. Collective. */
    void
    exchange_followed(const std::vector<char>          &acts,
                      std::vector<FollowedMotion<dim>> &followed) const;
    /** Add the derivative across pairs to the matrix. */
    void
    add_across(const StepData<dim>                    &step,
               const std::vector<FollowedMotion<dim>> &followed,
               const PairMatrices                     &derivatives,
               Matrix                                 &jacobian) const;

    /** What the last step found on this rank. */
    struct Found
    {
      std::vector<dealii::Tensor<1, dim>> force; ///< on the groups, N
      double                              n_touching = 0.;
      PairSprings<dim>                    springs;
      double                              overlap = 0.; ///< at the start, J
    };

    const ContactRules<dim>                 rules;
    const std::vector<std::string>          group_names;
    const Fields                            fields;
    const std::vector<ParticleCorners<dim>> corners_of_body;
    /** xi by body and point. */
    const std::vector<std::vector<dealii::Tensor<1, dim>>> points_of_body;
    double                                                 least_margin; ///< m
    double                                                 margin;       ///< m
    unsigned int                        here = 0; ///< this rank
    Candidates<dim>                     candidates;
    std::vector<PairLaw>                laws;     ///< of their pairs
    std::vector<dealii::Tensor<1, dim>> places;   ///< of their points at t, m
    std::vector<Where>                  where;    ///< of the candidates
    std::vector<unsigned int>           in_order; ///< of the stencils
    std::vector<Clique>                 cliques;
    /** By pair of candidates; what touches joins. */
    mutable std::vector<char> is_coupled;
    ContactExchange<dim>      exchange;
    /** At t, on the ranks that own the first particles; all those of now. */
    PairSprings<dim> springs, springs_held;
    mutable Found    found;
  };
} // namespace emmy

#endif
