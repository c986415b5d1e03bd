#ifndef emmy_particles_gimp_h
#define emmy_particles_gimp_h

#include <emmy/particles/field_layout.h>
#include <emmy/particles/stencils.h>
#include <emmy/particles/tails.h>

#include <optional>
#include <tuple>

namespace emmy
{
  /** A shape function in one direction and its derivative with respect to x. */
  struct Weight
  {
    double value, slope; ///< 1, 1/m
  };

  /**
   * The hat functions of a row of nodes, averaged over a particle's domain
   * (Bardenhagen and Kober 2004), for a half-length of any size. In each cell
   * the hats are linear, so the average over the part of the domain in that
   * cell is the value at the part's centre; the parts are weighted with their
   * share of the domain. This form has no cases, and keeps sum S = 1, sum S' =
   * 0, sum S x = x to round-off, however small the domain.
   *
   * @param x       position of the particle, from the lower end of the first
   *                overlapped cell, m
   * @param l       half-length of the domain, m; 0: the hats at x, which lies
   *                in the first cell
   * @param h       cell size, m
   * @param n_cells how many cells the domain overlaps
   * @param weights gets those of the n_cells + 1 nodes
   * @param beyond_lower,beyond_upper whether the domain goes a hair beyond
   *   these cells; the hats of the outermost ones are continued there
   */
  void
  gimp_weights(const double       x,
               const double       l,
               const double       h,
               const unsigned int n_cells,
               Weight            *weights,
               const bool         beyond_lower = false,
               const bool         beyond_upper = false);

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

    static EffectCard
    card();

    using ShapeFunctions<dim>::evaluate;

    Places<dim>
    places(const dealii::Particles::ParticleHandler<dim> &particles,
           const BackgroundGrid<dim>                     &grid) const override;
    Stencils<dim>
    evaluate(const Places<dim>         &places,
             const BackgroundGrid<dim> &grid) const override;
    void
    differentiate(const Places<dim>                   &places,
                  const std::size_t                    i,
                  const typename Stencils<dim>::Group &group,
                  const BackgroundGrid<dim>           &grid,
                  PlaceDerivatives<dim>               &result) const override;

  private:
    using Cell    = typename BackgroundGrid<dim>::Cell;
    using Lattice = typename BackgroundGrid<dim>::Lattice;
    using Group   = typename Stencils<dim>::Group;

    /** A particle, and the part of the grid that its domain overlaps. */
    struct Entry
    {
      std::size_t  index; ///< among the places
      unsigned int body;
      Lattice      first, last; ///< cells
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
    add_nodes(const Entry               &entry,
              const BackgroundGrid<dim> &grid,
              Group                     &group,
              Stencils<dim>             &stencils,
              std::vector<Cell>         &overlapped) const;

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

  /** Cells of a row that a box overlaps, counted from the grid's lower side. */
  struct Overlap
  {
    unsigned int first, last;
    bool         beyond_lower, beyond_upper; ///< a hair further
    double       tails; ///< least share of an outermost node, about; or 1
  };

  /**
   * @param below   from the grid's lower side to the particle, m
   * @param l       half-length as used, m
   * @param h       cell size, m
   * @param n_cells of the row
   */
  Overlap
  overlap_along(const double       below,
                const double       l,
                const double       h,
                const unsigned int n_cells);

  /** The half-length of a box in one direction as it is used. */
  struct UsedLength
  {
    double value;      ///< m
    double by_x, by_l; ///< how it changes with position and half-length
  };

  /**
   * @param l     half-length, m
   * @param h     cell size, m
   * @param below from the grid's lower side to the particle, m
   * @param above from there to the upper side, m
   */
  UsedLength
  used_half_length(const double l,
                   const double h,
                   const double below,
                   const double above);

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
  std::vector<typename BackgroundGrid<dim>::Cell>
  owned_among_active(
    const std::vector<typename BackgroundGrid<dim>::Cell> &found,
    const BackgroundGrid<dim>                             &grid);
} // namespace emmy

#endif
