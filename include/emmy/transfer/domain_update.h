#ifndef emmy_transfer_domain_update_h
#define emmy_transfer_domain_update_h

#include <emmy/base/effect_card.h>
#include <emmy/particles/body.h>
#include <emmy/particles/point_arrays.h>
#include <emmy/system/active_grid.h>

#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /** The half-lengths of a box in the middle of a step. */
  template <int dim>
  struct MiddleBox
  {
    dealii::Tensor<1, dim> half_length; ///< l_i, m
    /** dl_i/dL, with L of Stencils::displacement_gradient(), m. */
    std::array<dealii::Tensor<2, dim>, dim> by_L;
  };

  /**
   * How the domains of GIMP follow the deformation (Coombs et al. 2020): new
   * half-lengths l from those at the start of the run, l0, and the accepted
   * step. Owned by the scene; used once per accepted step, on trial states,
   * and, where the step takes its geometry in the middle, while it is solved.
   */
  template <int dim>
  class DomainUpdate
  {
  public:
    virtual ~DomainUpdate() = default;

    /**
     * @param points       states at t
     * @param displacement of the step at the local nodes, [dim * node + c], m
     * @param trial        states at t + dt; gets the half-lengths
     */
    virtual void
    operator()(const Stencils<dim>       &stencils,
               const PointArrays<dim>    &points,
               const ActiveGrid<dim>     &active,
               const std::vector<double> &displacement,
               PointArrays<dim>          &trial) const = 0;

    /**
     * The box of a particle in the middle of a step, where F_mid = Z F_t.
     * @param states at t
     * @param p      the particle in them
     * @param Z      (I - L/2)^-1
     */
    virtual MiddleBox<dim>
    middle(const PointArrays<dim>       &states,
           const std::size_t             p,
           const unsigned int            body,
           const dealii::Tensor<2, dim> &Z) const = 0;

    /**
     * What is wrong with the half-lengths on this rank, if anything: they must
     * stay above 1e-6 h.
     */
    static std::string
    problem(const Stencils<dim>       &stencils,
            const FieldLayout         &layout,
            const BackgroundGrid<dim> &grid,
            const PointArrays<dim>    &trial);

    /**
     * How many particles have domains of more than two cells; the shape
     * functions cut them at that size. Collective.
     */
    static std::uint64_t
    n_cut(const FieldLayout         &layout,
          const BackgroundGrid<dim> &grid,
          const PointArrays<dim>    &trial);
  };

  /** The name of an update, in the table of times. */
  constexpr const char *domain_update_effect = "domain update";

  /**
   * What an update costs; present unless @p update is null. Its field is asked
   * for by make_domain_update() and not named here.
   */
  template <int dim>
  EffectCard
  domain_update_card(const DomainUpdate<dim> *update);

  /** The names of the updates, separated by |. */
  std::string
  domain_update_names();

  /**
   * The update that the name stands for, one of domain_update_names(); with F =
   * deformation gradient:
   * - none: l = l0; null, as there is nothing to do;
   * - detF: l = l0 (det F)^(1/dim);
   * - diagF: l_i = l0_i F_ii, which can vanish under rotation;
   * - stretch: l_i = l0_i U_ii, U = sqrt(F^T F);
   * - corners: half the extent of the moved corners of the domain, scaled to
   *   the volume det F prod 2 l0. Of a domain longer than two cells the corners
   *   of the part that the shape functions use are moved, and their extent in
   *   each direction is scaled up: exact only without shear. In the middle of
   *   a step the domain is that of its start.
   *
   * @param layout asked for F by diagF and stretch alone
   */
  template <int dim>
  std::unique_ptr<DomainUpdate<dim>>
  make_domain_update(const std::string            &name,
                     const std::vector<Body<dim>> &bodies,
                     const BackgroundGrid<dim>    &grid,
                     FieldLayout                  &layout);
} // namespace emmy

#endif
