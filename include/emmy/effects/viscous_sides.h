#ifndef emmy_effects_viscous_sides_h
#define emmy_effects_viscous_sides_h

#include <emmy/effects/effect.h>

namespace emmy
{
  /** Section `Effects/Viscous sides`. */
  template <int dim>
  class ViscousSidesParameters : public EffectParameters<dim>
  {
  public:
    /** Declares the entries of a section. */
    explicit ViscousSidesParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

  private:
    std::vector<std::string> sides;
  };

  /**
   * Sides of the grid that take waves up (Lysmer and Kuhlemeyer 1969, J. Eng.
   * Mech. Div. ASCE 95, 859-877): a traction -rho c v on the material at a
   * side, with the speed of pressure waves along its normal n and that of shear
   * waves across. At the nodes of a side
   *
   *     f_A = sum_p m_p n.grad S_A (c_p n (x) n + c_s (I - n (x) n)) u_A/dt:
   *
   * the sum of V_p n.grad S_A is the area of a node where the cells at the side
   * are full. What it takes up, u.f, is never negative. A wave that meets the
   * side head on leaves; at a grazing angle a part comes back. A side that does
   * no more than this does not hold the body: it creeps under a constant load.
   *
   * Cost: a pass over the groups.
   */
  template <int dim>
  class ViscousSides : public ForceTerm<dim>, public NodeCoupling<dim>
  {
  public:
    /** Speeds in the undeformed material of a body, m/s. */
    struct Waves
    {
      /** rho c of P- and of S-waves, Pa s/m. */
      double pressure, shear;
    };

    /** @param mass component of the points' mass */
    ViscousSides(std::vector<unsigned int> sides,
                 std::vector<Waves>        waves_of_body,
                 const unsigned int        mass);

    /** To be told where the grid ends: by classify(). */
    NodeCoupling<dim> *
    coupling() override
    {
      return this;
    }
    void
    classify(const Stencils<dim>       &stencils,
             const PointArrays<dim>    &points,
             const BackgroundGrid<dim> &grid) override;
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

  private:
    /**
     * This rank's share of the force by displacement, N/m: diagonal,
     * [dim * node + c] over the local nodes.
     */
    std::vector<double>
    stiffness(const StepData<dim> &step) const;

    const std::vector<unsigned int> sides;
    const std::vector<Waves>        waves_of_body;
    const unsigned int              mass;
    const BackgroundGrid<dim>      *grid = nullptr;
  };
} // namespace emmy

#endif
