#include <deal.II/numerics/rtree.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/tool_mesh.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace emmy
{
  using dealii::BoundingBox;
  using dealii::Point;
  using dealii::Tensor;

  namespace
  {
    /** Normals that differ by less are one: files have single precision. */
    constexpr double same = 1e-6;

    /** I - n n^T (- t t^T, of an edge). */
    Tensor<2, 3>
    across(const Tensor<1, 3> &n, const Tensor<1, 3> &t)
    {
      Tensor<2, 3> result = -1. * (outer_product(n, n) + outer_product(t, t));
      for (unsigned int d = 0; d < 3; ++d)
        result[d][d] += 1.;
      return result;
    }
  } // namespace

  struct MeshShape::Tree
  {
    dealii::RTree<std::pair<BoundingBox<3>, unsigned int>> boxes;
  };

  MeshShape::MeshShape(TriangleSurface given, const double rounding)
    : surface(std::move(given))
    , rounding(rounding)
    , box(surface.corners)
    , tree(std::make_unique<Tree>())
  {
    find_normals();
    find_edges();
    find_corners();
    std::vector<std::pair<BoundingBox<3>, unsigned int>> boxes;
    for (unsigned int face = 0; face < surface.faces.size(); ++face)
      {
        const std::vector<Point<3>> all{corner(face, 0),
                                        corner(face, 1),
                                        corner(face, 2)};
        boxes.emplace_back(BoundingBox<3>(all), face);
      }
    tree->boxes = dealii::pack_rtree(boxes);
  }

  MeshShape::~MeshShape() = default;

  void
  MeshShape::find_normals()
  {
    for (unsigned int face = 0; face < surface.faces.size(); ++face)
      {
        const Tensor<1, 3> n =
          cross_product_3d(corner(face, 1) - corner(face, 0),
                           corner(face, 2) - corner(face, 0));
        normals.push_back(n.norm() > 0. ? n / n.norm() : n);
      }
  }

  void
  MeshShape::find_edges()
  {
    std::map<std::pair<unsigned int, unsigned int>, Tensor<1, 3>> normal_of;
    for (unsigned int face = 0; face < surface.faces.size(); ++face)
      for (unsigned int i = 0; i < 3; ++i)
        normal_of[{surface.faces[face][i], surface.faces[face][(i + 1) % 3]}] =
          normals[face];
    edges.resize(surface.faces.size());
    for (unsigned int face = 0; face < surface.faces.size(); ++face)
      for (unsigned int i = 0; i < 3; ++i)
        {
          // the neighbour has the edge in the other direction
          const Tensor<1, 3> other = normal_of.at(
            {surface.faces[face][(i + 1) % 3], surface.faces[face][i]});
          Tensor<1, 3> along = corner(face, i + 1) - corner(face, i);
          along /= along.norm();
          edges[face][i] = {normals[face] + other,
                            along,
                            (normals[face] - other).norm() < same};
        }
  }

  void
  MeshShape::find_corners()
  {
    corners.resize(surface.corners.size());
    std::vector<std::vector<Tensor<1, 3>>> around(corners.size());
    for (unsigned int face = 0; face < surface.faces.size(); ++face)
      for (unsigned int i = 0; i < 3; ++i)
        {
          const unsigned int  c = surface.faces[face][i];
          const Tensor<1, 3> &n = normals[face];
          const Tensor<1, 3>  a = corner(face, i + 1) - corner(face, i),
                             b  = corner(face, i + 2) - corner(face, i);
          corners[c].normal +=
            std::acos(std::clamp(a * b / (a.norm() * b.norm()), -1., 1.)) * n;
          if (std::none_of(around[c].begin(),
                           around[c].end(),
                           [&n](const Tensor<1, 3> &one) {
                             return (one - n).norm() < same;
                           }))
            around[c].push_back(n);
        }
    for (unsigned int c = 0; c < corners.size(); ++c)
      {
        corners[c].is_flat = around[c].size() < 2;
        if (around[c].size() != 2)
          continue;
        corners[c].along = cross_product_3d(around[c][0], around[c][1]);
        if (const double length = corners[c].along.norm(); length > 0.)
          corners[c].along /= length;
      }
  }

  MeshShape::Nearest
  MeshShape::nearest_of(const unsigned int face, const Tensor<1, 3> &r) const
  {
    // the regions of Ericson, Real-Time Collision Detection (2005), sec. 5.1.5
    const Tensor<1, 3> a = corner(face, 0), b = corner(face, 1),
                       c = corner(face, 2), ab = b - a, ac = c - a;
    const Tensor<1, 3> ap = r - a, bp = r - b, cp = r - c;
    const double       d1 = ab * ap, d2 = ac * ap, d3 = ab * bp, d4 = ac * bp,
                 d5 = ab * cp, d6 = ac * cp;
    if (d1 <= 0. && d2 <= 0.)
      return {ap, 4};
    if (d3 >= 0. && d4 <= d3)
      return {bp, 5};
    if (d6 >= 0. && d5 <= d6)
      return {cp, 6};
    if (d1 * d4 - d3 * d2 < 0. && d1 >= 0. && d3 <= 0.)
      return {ap - d1 / (d1 - d3) * ab, 1};
    if (d5 * d2 - d1 * d6 < 0. && d2 >= 0. && d6 <= 0.)
      return {ap - d2 / (d2 - d6) * ac, 3};
    if (d3 * d6 - d5 * d4 < 0. && d4 - d3 >= 0. && d5 - d6 >= 0.)
      return {bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), 2};
    return {(normals[face] * ap) * normals[face], 0};
  }

  double
  MeshShape::least_distance(const Tensor<1, 3> &r) const
  {
    Tensor<1, 3> beyond;
    for (unsigned int d = 0; d < 3; ++d)
      beyond[d] =
        std::max({box.lower_bound(d) - r[d], r[d] - box.upper_bound(d), 0.});
    const double gap = beyond.norm();
    return gap > 0. ? gap - rounding : std::numeric_limits<double>::lowest();
  }

  SurfaceDistance<3>
  MeshShape::distance(const Tensor<1, 3> &r) const
  {
    namespace index     = boost::geometry::index;
    const Point<3> here = Point<3>(r);
    unsigned int   face = 0;
    Nearest        nearest{};
    double         least = std::numeric_limits<double>::max();
    for (auto it =
           tree->boxes.qbegin(index::nearest(here, surface.faces.size()));
         it != tree->boxes.qend();
         ++it)
      {
        if (boost::geometry::comparable_distance(here, it->first) > least)
          break;
        const Nearest candidate = nearest_of(it->second, r);
        if (candidate.from.norm_square() >= least)
          continue;
        least   = candidate.from.norm_square();
        nearest = candidate;
        face    = it->second;
      }
    SurfaceDistance<3> result{};
    const Crease      *crease = nearest.part == 0 ? nullptr
                                : nearest.part < 4
                                  ? &edges[face][nearest.part - 1]
                                  : &corners[surface.faces[face][nearest.part - 4]];
    if (!crease || crease->is_flat)
      {
        result.normal = normals[face];
        result.value =
          normals[face] * (r - Tensor<1, 3>(corner(face, 0))) - rounding;
        return result;
      }
    // along a straight edge it is as far
    const Tensor<1, 3> from =
      nearest.from - (crease->along * nearest.from) * crease->along;
    const double length = from.norm();
    const double sign   = from * crease->normal < 0. ? -1. : 1.;
    result.value        = sign * length - rounding;
    result.normal       = crease->normal / crease->normal.norm();
    if (!(length > 1e-14 * r.norm()))
      return result;
    result.normal    = sign / length * from;
    result.curvature = sign / length * across(result.normal, crease->along);
    return result;
  }

  namespace
  {
    class MeshToolParameters : public ToolShapeParameters<3>
    {
    public:
      explicit MeshToolParameters(const std::string &section)
        : ToolShapeParameters<3>(section)
      {
        add_parameter("File",
                      file,
                      "A closed surface of triangles, STL, OBJ, PLY or OFF, "
                      "whose origin stands at the reference point. Required.");
        add_parameter("Scale",
                      scale,
                      "Lengths in the file times this are in m: 1e-3 for "
                      "millimetres.",
                      prm,
                      dealii::Patterns::Double());
        add_parameter("Rounding",
                      rounding,
                      "The tool is that much thicker than the surface, and "
                      "its edges are round. Half the spacing of the particles "
                      "lets their corners slide around them. 0: sharp edges. "
                      "Unit: m, not negative.",
                      prm,
                      dealii::Patterns::Double());
      }

      std::unique_ptr<ToolShape<3>>
      make() const override
      {
        AssertThrow(rounding >= 0.,
                    ExcParameter(path(),
                                 "Rounding",
                                 shortest(rounding),
                                 "must not be negative (m)."));
        TriangleSurface surface = read_triangles(file, scale, path(), "File");
        for (const auto &[a, b, c] : surface.faces)
          AssertThrow(
            cross_product_3d(surface.corners[b] - surface.corners[a],
                             surface.corners[c] - surface.corners[a])
                .norm() > 0.,
            ExcParameter(path(),
                         "File",
                         file,
                         "it has a triangle without area, at (" +
                           dealii::Patterns::Tools::to_string(
                             surface.corners[a]) +
                           ") m. Remove it, e.g. with MeshLab or Blender."));
        return std::make_unique<MeshShape>(std::move(surface), rounding);
      }

    private:
      std::string file;
      double      scale = 1., rounding = 0.;
    };
  } // namespace

  std::unique_ptr<ToolShapeParameters<3>>
  make_mesh_parameters(const std::string &section)
  {
    return std::make_unique<MeshToolParameters>(section);
  }
} // namespace emmy
