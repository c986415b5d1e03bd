#ifndef emmy_particles_gimp_h
#define emmy_particles_gimp_h

#include <emmy/particles/field_layout.h>
#include <emmy/particles/gimp_weights.h>
#include <emmy/particles/stencils.h>
#include <emmy/particles/tails.h>

#include <optional>
#include <tuple>

namespace emmy
{
  /**
   * Generalised interpolation (GIMP): a particle is a box of half-lengths l,
   * and reaches the nodes of all cells that its box overlaps. At the edge of
   * the grid the box is clipped so that it stays centred on the particle;
   * where less than 1e-6 h is left, the particle is a point with the linear
   * functions of its cell
   * (formulation of Pretti et al. 2023, sec. 3; Charlton et al. 2017). Boxes
   * of more than two cells act as if cut at that size: they would reach beyond
   * the neighbours of their cell.
   *
   * A box reaches a node if it gives it a share of at least 1e-12. In a cell in
   * which it would give less to the nodes behind, in value and slope alike, the
   * functions of the cell before are continued; at edges and corners of boxes
   * see Tails. All sums stay exact.
   *
   * Particles that overlap the same cells and are of one body share a group.
   * Cost per step: a sort of the particles, and up to 3^dim weights each while
   * l <= h/2.
   */
  template <int dim>
  class GimpShapeFunctions : public ShapeFunctions<dim>
  {
  public:
    /** @param layout asked for the half-lengths of each particle */
    explicit GimpShapeFunctions(FieldLayout &layout);

    /** What `emmy --check` says of it. */
    static EffectCard
    card();

    using ShapeFunctions<dim>::evaluate;

    Places<dim>
    places(const dealii::Particles::ParticleHandler<dim> &particles,
           const BackgroundGrid<dim>                     &grid) const override;
    Stencils<dim>
    evaluate(const Places<dim>         &places,
             const BackgroundGrid<dim> &grid) const override;
    /** Weights and their derivatives with respect to place and half-lengths. */
    void
    differentiate(const Places<dim>                   &places,
                  const std::size_t                    i,
                  const typename Stencils<dim>::Group &group,
                  const BackgroundGrid<dim>           &grid,
                  PlaceDerivatives<dim>               &result) const override;

  private:
    using Cell  = typename BackgroundGrid<dim>::Cell;
    using Group = typename Stencils<dim>::Group;

    /** A particle, and the part of the grid that its domain overlaps. */
    struct Entry
    {
      std::size_t  index; ///< among the places
      unsigned int body;
      CellKey<dim> first, last; ///< cells
      /** Half-lengths as used, m: shrunk by round-off and clipped. */
      dealii::Tensor<1, dim> half_length;
      /** Whether the box goes a hair beyond these cells. */
      std::array<bool, dim> beyond_lower, beyond_upper;
      /** Nodes of these cells that it does not reach: bits. */
      std::uint64_t left_out = 0;

      /** Entries of one group have the same. */
      auto
      key() const
      {
        return std::tie(first, last, body, left_out);
      }
    };

    /** The particles of this rank, sorted into groups. */
    std::vector<Entry>
    sorted_entries(const Places<dim>         &places,
                   const BackgroundGrid<dim> &grid) const;

    /** Behind the last that is of the same group as the first. */
    static std::size_t
    end_of_group(const std::vector<Entry> &entries, const std::size_t first);

    /**
     * The weights' arrays in their full length, and room for nodes and groups:
     * arrays that grow stand there twice.
     */
    static void
    make_room(const std::vector<Entry> &entries, Stencils<dim> &stencils);

    static void
    set_overlap(const Places<dim>         &places,
                const BackgroundGrid<dim> &grid,
                Entry                     &entry);

    /** Which nodes of the overlapped cells the particle does not reach. */
    static std::uint64_t
    nodes_left_out(const Places<dim>         &places,
                   const BackgroundGrid<dim> &grid,
                   const Entry               &entry);

    /**
     * The nodes of the cells of a group, x fastest; and those cells.
     * @return false if this rank does not know them
     */
    bool
    add_nodes(const Entry                  &entry,
              const BackgroundGrid<dim>    &grid,
              Group                        &group,
              Stencils<dim>                &stencils,
              std::vector<ActiveCell<dim>> &overlapped) const;

    /** The weights of a particle by direction, from the origin of its cells. */
    static std::array<std::array<Weight, 4>, dim>
    weights_along(const Entry               &entry,
                  const Places<dim>         &places,
                  const BackgroundGrid<dim> &grid,
                  const dealii::Point<dim>  &origin);

    /** S and grad S of the particles of a group, @p first and following. */
    void
    add_weights(const Entry               *first,
                const Places<dim>         &places,
                const BackgroundGrid<dim> &grid,
                const Group               &group,
                Stencils<dim>             &stencils) const;

    const unsigned int body_component, half_length_component;
  };

  /**
   * Let all ranks stop together where a particle reaches a cell that its rank
   * does not know. Collective; throws ExcRun.
   * @param index among the places, of a particle of this rank that does;
   *   nothing if none does
   */
  template <int dim>
  void
  stop_at_unknown_cell(const Places<dim>               &places,
                       const std::optional<std::size_t> index,
                       const BackgroundGrid<dim>       &grid);

  /**
   * Cells that any rank found to be active, @p found sorted and without
   * repetition, reported to their owners.
   * @return the active cells that this rank owns, in the grid's order.
   *   Collective.
   */
  template <int dim>
  std::vector<ActiveCell<dim>>
  owned_among_active(const std::vector<ActiveCell<dim>> &found,
                     const BackgroundGrid<dim>          &grid);
} // namespace emmy

#endif
