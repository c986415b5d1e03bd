#ifndef emmy_particles_stencils_h
#define emmy_particles_stencils_h

#include <deal.II/base/types.h>

#include <deal.II/particles/particle_handler.h>

#include <emmy/base/library.h>
#include <emmy/base/unknown.h>
#include <emmy/grid/background_grid.h>
#include <emmy/particles/field_layout.h>
#include <emmy/particles/place_derivatives.h>
#include <emmy/particles/places.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /** A cell, and a velocity field that has particles in it. */
  template <int dim>
  struct ActiveCell
  {
    typename BackgroundGrid<dim>::Cell cell;  ///< of deal.II's grid
    unsigned int                       field; ///< the velocity field

    /** By place, then by field. */
    bool
    operator<(const ActiveCell &other) const
    {
      return cell != other.cell ? cell < other.cell : field < other.field;
    }
    /** Same cell and field. */
    bool
    operator==(const ActiveCell &other) const
    {
      return cell == other.cell && field == other.field;
    }
  };

  /**
   * Which nodes each particle of this rank talks to during a step, and with
   * what weights: the shape functions S and their gradients at the particles'
   * places, those of the start of the step or of its middle. Particles that
   * share their nodes and their body stand together in a group, so that the
   * point loops work on contiguous arrays. Never changes once it is made.
   */
  template <int dim>
  struct Stencils
  {
    /** deal.II's. */
    using ParticleIterator = dealii::Particles::ParticleIterator<dim>;

    /** Particles of one body in one cell. */
    struct Group
    {
      std::size_t  first_point; ///< in the order of the points
      unsigned int n_points;    ///< of this group
      unsigned int body;        ///< of all of them
      std::size_t  first_node;  ///< in node_ids
      unsigned int n_nodes;     ///< that they reach
      std::size_t  first_value; ///< in values; dim times it in gradients
      /** Nodes per direction of a box of cells; x fastest. */
      std::array<unsigned int, dim> n_along;
      /** The first node, m. */
      dealii::Point<dim> origin;
      /** Bits: nodes of that box that the points do not reach, see Tails. */
      std::uint64_t left_out = 0;
    };

    std::vector<Group> groups; ///< cell by cell

    /** Ids of the nodes of all groups, one group after the other. */
    std::vector<dealii::types::global_dof_index> node_ids;
    /** S of the group's node a at its point p: [a * n_points + p]. */
    std::vector<double> values;
    /** dS/dx_d, 1/m: [(a * dim + d) * n_points + p]. */
    std::vector<double> gradients;

    /** The particle behind each point, and its index among the places. */
    std::vector<ParticleIterator> particles;
    std::vector<std::size_t>      order; ///< of particles: place in the groups

    /**
     * Whether the grid is undeformed in the middle of the step, at t + dt/2,
     * and the places are those of then; else all is of the start, t.
     */
    bool at_middle = false;

    /**
     * The active cells that this rank owns, sorted by their places; once in
     * each field.
     */
    std::vector<ActiveCell<dim>> active_cells;

    /** Weights S of a node, by particle. */
    const double *
    value(const Group &group, const unsigned int node) const
    {
      return values.data() + group.first_value + node * group.n_points;
    }
    /** Component of the gradients of a node, by particle, 1/m. */
    const double *
    gradient(const Group       &group,
             const unsigned int node,
             const unsigned int d) const
    {
      return gradients.data() + dim * group.first_value +
             (node * dim + d) * group.n_points;
    }

    /**
     * L = sum u_a (x) grad S_a at point q of a group.
     * @param nodes local indices of the group's nodes
     * @param u     displacements at local nodes, [dim * node + c]
     */
    dealii::Tensor<2, dim>
    displacement_gradient(const Group               &group,
                          const unsigned int         q,
                          const unsigned int        *nodes,
                          const std::vector<double> &u) const
    {
      dealii::Tensor<2, dim> L;
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            L[i][j] += u[unknown<dim>(nodes[a], i)] * gradient(group, a, j)[q];
      return L;
    }

    /**
     * H = Delta F - I with respect to positions at t, whichever the grid is
     * undeformed at: L, or L (I - L/2)^-1 of the middle.
     */
    dealii::Tensor<2, dim>
    step_gradient(const Group               &group,
                  const unsigned int         q,
                  const unsigned int        *nodes,
                  const std::vector<double> &u) const
    {
      const auto L = displacement_gradient(group, q, nodes, u);
      if (!at_middle)
        return L;
      dealii::Tensor<2, dim> from_start = -0.5 * L;
      for (unsigned int d = 0; d < dim; ++d)
        from_start[d][d] += 1.;
      return L * invert(from_start);
    }
  };

  /**
   * Call function(a, index) for the nodes a of a group, with their places in
   * its box of nodes.
   */
  template <int dim, class Function>
  void
  for_each_node(const typename Stencils<dim>::Group &group,
                const Function                      &function)
  {
    std::array<unsigned int, dim> index{};
    for (unsigned int in_box = 0, a = 0, d = 0; d < dim; ++in_box)
      {
        if (!(group.left_out >> in_box & 1))
          function(a++, index);
        for (d = 0; d < dim && ++index[d] == group.n_along[d]; ++d)
          index[d] = 0;
      }
  }

  /**
   * Call function(index) for the cells of a group, with their places in its
   * box of cells: those of which it has all nodes.
   */
  template <int dim, class Function>
  void
  for_each_cell_of(const typename Stencils<dim>::Group &group,
                   const Function                      &function)
  {
    std::array<unsigned int, dim> index{};
    for (unsigned int d = 0; d < dim;)
      {
        bool has_all = true;
        for (unsigned int v = 0; v < (1u << dim); ++v)
          {
            unsigned int in_box = 0;
            for (unsigned int e = dim; e-- > 0;)
              in_box = in_box * group.n_along[e] + index[e] + ((v >> e) & 1);
            has_all = has_all && !(group.left_out >> in_box & 1);
          }
        if (has_all)
          function(index);
        for (d = 0; d < dim && ++index[d] + 1 == group.n_along[d]; ++d)
          index[d] = 0;
      }
  }

  /** How points and nodes are connected: linear functions or GIMP. */
  template <int dim>
  class ShapeFunctions
  {
  public:
    virtual ~ShapeFunctions() = default;

    /** The particles of this rank where they are now. */
    virtual Places<dim>
    places(const dealii::Particles::ParticleHandler<dim> &particles,
           const BackgroundGrid<dim>                     &grid) const = 0;

    /**
     * The stencils of all particles of this rank at these places. Collective.
     * For every point they satisfy, to round-off, sum S = 1, sum grad S = 0,
     * sum S x = x_p, sum x (x) grad S = I: all conservation laws rest on this.
     */
    virtual Stencils<dim>
    evaluate(const Places<dim>         &places,
             const BackgroundGrid<dim> &grid) const = 0;

    /** The same where the particles are now. */
    Stencils<dim>
    evaluate(const dealii::Particles::ParticleHandler<dim> &particles,
             const BackgroundGrid<dim>                     &grid) const
    {
      return evaluate(places(particles, grid), grid);
    }

    /**
     * How the weights of particle @p i of the places change with its place.
     * @param group the one it is in
     */
    virtual void
    differentiate(const Places<dim>                   &places,
                  const std::size_t                    i,
                  const typename Stencils<dim>::Group &group,
                  const BackgroundGrid<dim>           &grid,
                  PlaceDerivatives<dim>               &result) const = 0;
  };

  /** All values of Method/Shape functions; made with the particles' layout. */
  template <int dim>
  Library<ShapeFunctions<dim>, FieldLayout &> &
  shape_function_library();

  /**
   * The bi- or trilinear functions of the cell that owns the particle
   * (standard MPM; Pretti et al. 2023, eq. 8). A particle on a face takes
   * value and slope from the one cell that owns it.
   */
  template <int dim>
  class LinearShapeFunctions : public ShapeFunctions<dim>
  {
  public:
    /** @param body_component where the particles keep the index of the body */
    explicit LinearShapeFunctions(const unsigned int body_component);

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
    void
    differentiate(const Places<dim>                   &places,
                  const std::size_t                    i,
                  const typename Stencils<dim>::Group &group,
                  const BackgroundGrid<dim>           &grid,
                  PlaceDerivatives<dim>               &result) const override;

  private:
    /** S and grad S of the points of a group. */
    static void
    add_weights(const Places<dim>                   &places,
                const typename Stencils<dim>::Group &group,
                const dealii::Tensor<1, dim>        &h,
                Stencils<dim>                       &stencils);

    const unsigned int body_component;
  };

  /** Where the particles of this rank are, without boxes. */
  template <int dim>
  Places<dim>
  places_now(const dealii::Particles::ParticleHandler<dim> &particles,
             const BackgroundGrid<dim>                     &grid,
             const unsigned int                             body_component);
} // namespace emmy

#endif
