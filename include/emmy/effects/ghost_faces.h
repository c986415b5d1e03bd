#ifndef emmy_effects_ghost_faces_h
#define emmy_effects_ghost_faces_h

#include <deal.II/lac/full_matrix.h>

#include <emmy/grid/boundary_conditions.h>
#include <emmy/material/material.h>
#include <emmy/particles/stencils.h>

#include <algorithm>
#include <map>
#include <vector>

namespace emmy
{
  /** A face between two active cells whose jump of slopes is penalised. */
  template <int dim>
  struct GhostFace
  {
    /** Nodes of a layer normal to the face; there are three layers. */
    static constexpr unsigned int nodes_per_layer = 1 << (dim - 1);
    /** Of the cells on both sides. */
    static constexpr unsigned int n_nodes = 3 * nodes_per_layer;

    unsigned int direction; ///< normal to the face
    /** Of the lower cell, the face, and the upper cell, layer by layer. */
    std::array<dealii::types::global_dof_index, n_nodes> node_ids;
    double mass;      ///< gamma_M rho, kg/m^3
    double stiffness; ///< gamma_K E_F / h_F^2, N/m^4
  };

  /** What is known of an active cell. */
  struct GhostCell
  {
    /** The largest of the particles, kg/m^3 and Pa. */
    double density = 0., modulus = 0.;
    bool   is_boundary = false; ///< whether the cell is at the edge of a body

    /** Take the larger of both. */
    void
    include(const double other_density, const double other_modulus)
    {
      density = std::max(density, other_density);
      modulus = std::max(modulus, other_modulus);
    }
  };

  /**
   * J of one face for bi- and trilinear functions (Burman 2010; Sticko,
   * Ludvigsson and Kreiss 2020): on the three layers of nodes the jump of the
   * normal derivative is delta = (1, -2, 1)/h, so
   * @f$ J_F = \tfrac{h^3}{3} (\delta\delta^T) \otimes m_F @f$ with the mass
   * matrix m_F of the face. In the order of GhostFace::node_ids, m^dim.
   */
  template <int dim>
  dealii::FullMatrix<double>
  ghost_matrix(const unsigned int            direction,
               const dealii::Tensor<1, dim> &sides);

  /** The name of the effect, in parameter files and the table of times. */
  constexpr const char *ghost_effect = "ghost stabilisation";

  /**
   * Finds the faces of ghost stabilisation, in each step anew. A boundary cell
   * is an active cell with a face neighbour that is not active; a side of the
   * grid counts as such a neighbour unless its normal displacement is given. A
   * ghost face lies between two active cells of which at least one is a
   * boundary cell. This is done in each velocity field for itself. Owned by the
   * effect.
   */
  template <int dim>
  class GhostFaces
  {
  public:
    /**
     * @param material_of_body borrowed materials, one per body: where two meet,
     *   the larger density and P-wave modulus count
     */
    GhostFaces(const double                       mass_penalty,
               const double                       stiffness_penalty,
               std::vector<const Material<dim> *> material_of_body);

    /**
     * The ghost faces whose lower cell this rank owns. Collective. Cost: some
     * look-ups for each group of points and each active cell.
     */
    std::vector<GhostFace<dim>>
    operator()(const Stencils<dim>           &stencils,
               const BackgroundGrid<dim>     &grid,
               const BoundaryConditions<dim> &boundary_conditions) const;

  private:
    /** Those of a field. Collective. */
    void
    add_faces(const std::map<CellKey<dim>, GhostCell> &owned,
              const unsigned int                       field,
              const BackgroundGrid<dim>               &grid,
              const BoundaryConditions<dim>           &boundary_conditions,
              std::vector<GhostFace<dim>>             &faces) const;

    const double mass_penalty, stiffness_penalty; // gamma_M, gamma_K
    const std::vector<const Material<dim> *> material_of_body;
  };
} // namespace emmy

#endif
