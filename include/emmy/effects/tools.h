#ifndef emmy_effects_tools_h
#define emmy_effects_tools_h

#include <emmy/effects/corner_forces.h>
#include <emmy/effects/tool_contact.h>
#include <emmy/effects/tool_motion.h>
#include <emmy/effects/tool_push.h>

#include <limits>
#include <optional>

namespace emmy
{
  /** A rigid body that moves as it is told, or as a force pushes it. */
  template <int dim>
  struct Tool
  {
    /** No field. */
    static constexpr unsigned int none =
      std::numeric_limits<unsigned int>::max();

    std::string                     name;   ///< as in `Names`
    std::unique_ptr<ToolShape<dim>> shape;  ///< where its surface is
    ToolMotion<dim>                 motion; ///< how it is moved
    /** beta: of the penalty, to the P-wave modulus over the spacing. */
    double stiffness;
    double friction;         ///< mu
    double spring_stiffness; ///< k_T/k
    /** Fields of the particles: xi by corner, [dim * corner + c]; which corners
     * are held, as bits. */
    unsigned int springs = none, held = none;
    /** Empty: it is not pushed. */
    std::optional<ToolPush<dim>> push = {};
  };

  /**
   * Rigid tools push particles, at all 2^dim corners of their boxes: y = x_p +
   * a, where a = F_p xi moves with the particle, so that y moves by dx_p + H_p
   * a and no force jumps from step to step. A force f there has the nodal
   * forces (S_A + g_A.a) f. Force, friction, and the frame of a tool that turns
   * are those of contact() and ToolStep: the work of a tool is stored, lost or
   * in the body, to round-off, whatever Newton has left. Where the grid is
   * undeformed in the middle of the step, a is that of the middle, a = Z a_t,
   * and dy = S u + L a; then the torque of f is that at the corner's place in
   * the middle. A tool that is pushed finds its way in each evaluation, and
   * is no unknown of Newton's: see pushed_motion(), PushCoupling. Each corner
   * has k = beta M s^(dim-2) / 2^(dim-1), with the
   * P-wave modulus M of its body and the spacing s of its particles.
   *
   * Cost: a sweep over the particles in each evaluation, with their
   * displacement gradients, and one distance for each tool; that of the
   * stiffness for those that touch.
   */
  template <int dim>
  class Tools : public Effect<dim>,
                public RankOneSource,
                public StepMemory,
                public StepMeasures<dim>
  {
  public:
    /** Numbers of the fields that the tools read. */
    struct Fields
    {
      /** Where a particle's body, and its F, are among its numbers. */
      unsigned int body, deformation_gradient;
    };

    /** All tools of a scene. */
    Tools(std::vector<Tool<dim>>            tools,
          const Fields                     &fields,
          std::vector<ParticleCorners<dim>> corners_of_body);

    /** Finds the corners that a tool holds; tells of overlaps. */
    std::string
    mark(const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const override;

    /** How deep corners have sunk in so far, as told in the log, of s; travel
     * and speed of each tool that is pushed. */
    StepMemory *
    memory() override
    {
      return this;
    }
    std::vector<double>
    contents() const override;
    void
    recall(const std::vector<std::vector<double>> &parts) override;

    bool
    is_force() const override
    {
      return true;
    }
    bool
    has_kinks() const override
    {
      return true;
    }
    std::string
    add(const StepData<dim> &step,
        const Iterate<dim>  &iterate,
        Vector              &force,
        Matrix              *jacobian) const override;
    const std::vector<RankOne> &
    rank_ones() const override
    {
      return found.rank_ones;
    }
    /** Moves the tools that are pushed. */
    void
    end_step(const double time, const double time_step) override;

    std::vector<EnergyEntry>
    energies(const StepData<dim>    &step,
             const Vector           &displacement,
             const PointArrays<dim> &accepted) const override;
    std::vector<EnergyEntry>
    energy_entries() const override;
    /** What overlaps has been stored, and put in by its tool. */
    std::vector<EnergyEntry>
    energies_at_start(const PointArrays<dim> &points,
                      const double            time) const override;

    StepMeasures<dim> *
    measures() override
    {
      return this;
    }
    /** Paths of the tools, and what acted on them in the last step. */
    std::vector<StepMeasure>
    measure(const PointArrays<dim>    &points,
            const double               time,
            const BackgroundGrid<dim> &grid) override;
    /** One for each tool. */
    std::vector<Surface<dim>>
    surfaces(const double              time,
             const dealii::Point<dim> &lower,
             const dealii::Point<dim> &upper) const override;
    /** Corners that sink in deeper than ever, by more than a share of s. */
    std::string
    finding() override;

    /** Names of the columns that a tool has. */
    static std::vector<std::string>
    columns_of(const std::string &name,
               const bool         is_turning,
               const bool         is_pushed);

  private:
    using Group = typename Stencils<dim>::Group;
    /** A corner that a tool acts on. */
    struct Touch
    {
      unsigned int           tool, corner;
      dealii::Tensor<1, dim> arm;        ///< a, m
      dealii::Tensor<1, dim> from;       ///< the tool's point, in the middle, m
      dealii::Tensor<1, dim> force;      ///< on the particle, N
      dealii::Tensor<2, dim> derivative; ///< by the corner's way, N/m
      const Contact<dim>    &contact;
    };

    /** All that is the same for the corners of a step. */
    struct Moves
    {
      std::vector<ToolStep<dim>> tools;
      std::vector<PushMotion>    pushed;  ///< 0 where it is not
      std::string                problem; ///< on all ranks
    };

    /** Those of the step at a displacement of the local nodes. Collective. */
    Moves
    motions(const StepData<dim>       &step,
            const std::vector<double> &local_displacement) const;
    /** Find the way of a tool that is pushed, and add it to its motion. */
    PushMotion
    push(const unsigned int         tool,
         const StepData<dim>       &step,
         const std::vector<double> &local_displacement,
         ToolStep<dim>             &motion) const;
    /** Which entry is the work of a tool; which its kinetic energy, if it is
     * pushed. */
    unsigned int
    work_of(const unsigned int tool) const;
    unsigned int
    kinetic_energy_of(const unsigned int tool) const
    {
      return work_of(tool) + 1;
    }
    /** Where the reference point is. */
    dealii::Point<dim>
    place_of(const unsigned int tool, const double time) const;
    CornerMotion<dim>
    particle(const StepData<dim>       &step,
             const Group               &group,
             const unsigned int         q,
             const std::vector<double> &local_displacement) const;
    /**
     * Call visit(touch) for what touches, also for a moment.
     * @return what is wrong: a corner has gone through a tool
     */
    template <class Visit>
    std::string
    for_each_touch(const StepData<dim>              &step,
                   const std::vector<ToolStep<dim>> &motions,
                   const CornerMotion<dim>          &particle,
                   const Visit                      &visit) const;
    /** The same of one tool. */
    template <class Visit>
    std::string
    for_each_touch_of(const unsigned int       tool,
                      const ToolStep<dim>     &motion,
                      const StepData<dim>     &step,
                      const CornerMotion<dim> &particle,
                      const Visit             &visit) const;
    /** A corner as its tool sees it at the start of a step. */
    ContactPoint<dim>
    point_of(const Tool<dim>         &tool,
             const unsigned int       corner,
             const ToolStep<dim>     &motion,
             const StepData<dim>     &step,
             const CornerMotion<dim> &particle) const;
    /** How tools that are pushed enter the derivative; of others null. */
    std::vector<std::unique_ptr<PushCoupling<dim>>>
    push_couplings(const StepData<dim>       &step,
                   const std::vector<double> &local_displacement) const;
    bool
    is_far(const ToolStep<dim>     &motion,
           const Tool<dim>         &tool,
           const CornerMotion<dim> &particle) const;
    ContactLaw
    law(const Tool<dim> &tool, const ParticleCorners<dim> &corners) const;
    bool
    is_held(const Tool<dim>   &tool,
            const double       bits,
            const unsigned int corner) const;
    /** Write F, and no springs, for those that touch nothing. */
    void
    begin_trial(const CornerMotion<dim> &particle,
                PointArrays<dim>        &trial) const;
    /** What a tool touches at the start of a run, in words. */
    std::string
    mark(const Tool<dim>                         &tool,
         const BackgroundGrid<dim>               &grid,
         dealii::Particles::ParticleHandler<dim> &particles) const;

    /** What the last evaluation, the last step found on this rank. */
    struct Found
    {
      std::optional<MPI_Comm>             communicator;
      double                              deepest = 0.; ///< of s
      std::vector<dealii::Tensor<1, dim>> force;        ///< on the tools, N
      std::vector<dealii::Tensor<1, 3>>   moment;       ///< N m
      std::vector<double>                 sunk_in;      ///< of s
      /** Of those pushed, in the step and at its end, m and m/s. */
      std::vector<double>  way, speed;
      std::vector<RankOne> rank_ones;
    };

    const std::vector<Tool<dim>>            tools;
    const Fields                            fields;
    const std::vector<ParticleCorners<dim>> corners_of_body;
    bool                                    has_friction = false;
    mutable Found                           found;
    std::vector<PushState>                  pushed;          ///< by tool
    double                                  told_depth = 0.; ///< of s
  };
} // namespace emmy

#endif
