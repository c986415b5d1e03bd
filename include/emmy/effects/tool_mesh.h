#ifndef emmy_effects_tool_mesh_h
#define emmy_effects_tool_mesh_h

#include <deal.II/base/bounding_box.h>

#include <emmy/effects/tool_shapes.h>
#include <emmy/particles/surface_mesh.h>

namespace emmy
{
  /**
   * A closed surface of triangles, and how far it is: the distance to the
   * nearest triangle, found in a tree of boxes, less a rounding. The sign is
   * that of the normal of the face, or of the mean normal of the edge or corner
   * that is nearest (Baerentzen and Aanaes 2005). Next to a face the distance
   * is that from its plane, so that it has all digits also on the surface.
   * Edges between faces of one plane, and corners on one plane or on one
   * straight edge, count as part of these. Its gradient jumps inside where two
   * faces are equally near.
   *
   * Cost: the logarithm of the number of triangles.
   */
  class MeshShape : public ToolShape<3>
  {
  public:
    /** @param surface closed, its faces counter-clockwise from outside */
    MeshShape(TriangleSurface surface, const double rounding);
    ~MeshShape() override;

    /** To the nearest triangle, m; negative inside. */
    SurfaceDistance<3>
    distance(const dealii::Tensor<1, 3> &r) const override;
    /** That from the box around it. */
    double
    least_distance(const dealii::Tensor<1, 3> &r) const override;

  private:
    /** What is nearest of a triangle. */
    struct Nearest
    {
      dealii::Tensor<1, 3> from; ///< to r, m
      /** 0: the face, 1 + i: the edge from corner i on, 4 + i: corner i. */
      unsigned int part;
    };
    /** An edge or a corner. */
    struct Crease
    {
      dealii::Tensor<1, 3> normal; ///< mean, any length
      dealii::Tensor<1, 3> along;  ///< of an edge; zero at a corner
      bool                 is_flat;
    };
    struct Tree;

    Nearest
    nearest_of(const unsigned int face, const dealii::Tensor<1, 3> &r) const;
    void
    find_normals();
    void
    find_edges();
    void
    find_corners();
    const dealii::Point<3> &
    corner(const unsigned int face, const unsigned int i) const
    {
      return surface.corners[surface.faces[face][i % 3]];
    }

    const TriangleSurface              surface;
    const double                       rounding;
    std::vector<dealii::Tensor<1, 3>>  normals; ///< of faces
    std::vector<std::array<Crease, 3>> edges;   ///< of faces
    std::vector<Crease>                corners;
    dealii::BoundingBox<3>             box;
    const std::unique_ptr<Tree>        tree;
  };

  /** The section of a tool of that shape. */
  std::unique_ptr<ToolShapeParameters<3>>
  make_mesh_parameters(const std::string &section);
} // namespace emmy

#endif
