#include <deal.II/base/geometry_info.h>

#include <deal.II/numerics/rtree.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/particles/surface_mesh.h>
#include <emmy/particles/volume_mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace emmy
{
  using dealii::BoundingBox;
  using dealii::Point;
  using dealii::Tensor;

  namespace
  {
    /** Points this near to a face lie on it; of a simplex's height. */
    constexpr double on_face = 1e-12;

    template <int dim>
    using Corners = std::array<Point<dim>, dim + 1>;

    /** A cell of the mesh, or a part of one. */
    template <int dim>
    class Simplex
    {
    public:
      Simplex(const Corners<dim> &corners, const unsigned int cell)
        : cell(cell)
        , corners(corners)
      {
        Tensor<2, dim> edges;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int d = 0; d < dim; ++d)
            edges[d][i] = corners[i + 1][d] - corners[0][d];
        volume = determinant(edges) / (dim == 2 ? 2. : 6.);
        if (volume != 0.)
          to_shares = invert(edges);
      }

      /** The least of the barycentric coordinates of a point. */
      double
      least_share(const Point<dim> &position) const
      {
        const Tensor<1, dim> shares = to_shares * (position - corners[0]);
        double               first = 1., least = 1.;
        for (unsigned int d = 0; d < dim; ++d)
          {
            first -= shares[d];
            least = std::min(least, shares[d]);
          }
        return std::min(first, least);
      }

      Point<dim>
      center() const
      {
        Tensor<1, dim> sum;
        for (const Point<dim> &corner : corners)
          sum += corner;
        return Point<dim>(sum / (dim + 1.));
      }

      BoundingBox<dim>
      box() const
      {
        Point<dim> lower = corners[0], upper = corners[0];
        for (const Point<dim> &corner : corners)
          for (unsigned int d = 0; d < dim; ++d)
            {
              lower[d] = std::min(lower[d], corner[d]);
              upper[d] = std::max(upper[d], corner[d]);
            }
        return BoundingBox<dim>({lower, upper});
      }

      unsigned int cell;
      Corners<dim> corners;
      double       volume; ///< negative: turned inside out

    private:
      Tensor<2, dim> to_shares;
    };

    template <int dim>
    class VolumeMesh : public Shape<dim>
    {
    public:
      explicit VolumeMesh(std::vector<Simplex<dim>> parts)
        : simplices(std::move(parts))
      {
        std::vector<std::pair<BoundingBox<dim>, unsigned int>> boxes;
        Tensor<1, dim>                                         moment;
        for (unsigned int i = 0; i < simplices.size(); ++i)
          {
            boxes.emplace_back(simplices[i].box(), i);
            content += simplices[i].volume;
            moment += simplices[i].volume * simplices[i].center();
            if (i == 0)
              bounds = boxes[i].first;
            bounds.merge_with(boxes[i].first);
          }
        middle = Point<dim>(moment / content);
        tree   = dealii::pack_rtree(boxes);
      }

      bool
      contains(const Point<dim> &position) const override
      {
        return is_in(position, -on_face, dealii::numbers::invalid_unsigned_int);
      }

      double
      volume() const override
      {
        return content;
      }

      bool
      center(Point<dim> &center) const override
      {
        center = middle;
        return true;
      }

      BoundingBox<dim>
      bounding_box() const override
      {
        return bounds;
      }

      /** A point that lies in two cells, if one is found. */
      std::string
      overlap() const
      {
        constexpr double towards_corner = 0.95, inside = 1e-6;
        for (const Simplex<dim> &one : simplices)
          for (unsigned int i = 0; i <= dim + 1; ++i)
            {
              const Point<dim> from = one.center();
              const Point<dim> point =
                i > dim
                  ? from
                  : Point<dim>(from + towards_corner * (one.corners[i] - from));
              if (is_in(point, inside, one.cell))
                return dealii::Patterns::Tools::to_string(point);
            }
        return "";
      }

    private:
      /** Whether a cell other than @p except holds the point that deep. */
      bool
      is_in(const Point<dim>  &position,
            const double       depth,
            const unsigned int except) const
      {
        namespace bgi = boost::geometry::index;
        for (auto found = tree.qbegin(bgi::intersects(position));
             found != tree.qend();
             ++found)
          if (const auto &one = simplices[found->second];
              one.cell != except && one.least_share(position) >= depth)
            return true;
        return false;
      }

      const std::vector<Simplex<dim>>                          simplices;
      dealii::RTree<std::pair<BoundingBox<dim>, unsigned int>> tree;
      double                                                   content = 0.;
      Point<dim>                                               middle;
      BoundingBox<dim>                                         bounds;
    };

    /**
     * The facets of a quadrilateral or hexahedron, seen counter-clockwise from
     * outside: lines, or triangles.
     */
    template <int dim>
    std::vector<std::array<unsigned int, dim>>
    facets(const std::vector<MeshCorner<dim>> &corners)
    {
      using Cell = dealii::GeometryInfo<dim>;
      std::vector<std::array<unsigned int, dim>> result;
      for (unsigned int f = 0; f < Cell::faces_per_cell; ++f)
        {
          std::array<unsigned int, Cell::vertices_per_face> v;
          for (unsigned int i = 0; i < v.size(); ++i)
            v[i] = Cell::face_to_cell_vertices(f, i);
          if constexpr (dim == 2) // lines along x point along x, and so on
            result.push_back(f == 1 || f == 2
                               ? std::array<unsigned int, 2>{{v[0], v[1]}}
                               : std::array<unsigned int, 2>{{v[1], v[0]}});
          else
            {
              std::array<unsigned int, 4> around{{v[0], v[1], v[3], v[2]}};
              if (f % 2 == 0) // its two directions turn about the inner normal
                std::swap(around[1], around[3]);
              // both neighbours cut from the corner with the least number
              std::rotate(around.begin(),
                          std::min_element(around.begin(),
                                           around.end(),
                                           [&](const auto a, const auto b) {
                                             return corners[a].second <
                                                    corners[b].second;
                                           }),
                          around.end());
              result.push_back({{around[0], around[1], around[2]}});
              result.push_back({{around[0], around[2], around[3]}});
            }
        }
      return result;
    }

    /** Append the simplices of a cell. */
    template <int dim>
    void
    append_parts(const std::vector<MeshCorner<dim>> &corners,
                 const unsigned int                  cell,
                 std::vector<Simplex<dim>>          &parts)
    {
      Corners<dim> part;
      if (corners.size() == dim + 1)
        {
          for (unsigned int i = 0; i <= dim; ++i)
            part[i] = corners[i].first;
          parts.emplace_back(part, cell);
          return;
        }
      Tensor<1, dim> sum;
      for (const auto &corner : corners)
        sum += corner.first;
      part[0] = Point<dim>(sum / double(corners.size()));
      for (const auto &facet : facets<dim>(corners))
        {
          for (unsigned int i = 0; i < dim; ++i)
            part[i + 1] = corners[facet[i]].first;
          parts.emplace_back(part, cell);
        }
    }

    /** Cells that can be a body, or a message. */
    template <int dim, class Require>
    std::vector<Simplex<dim>>
    sound_parts(MeshCells<dim> &cells,
                const double    scale,
                const Require  &require)
    {
      std::vector<Simplex<dim>> parts;
      unsigned int              n_flat = 0, number = 0;
      std::string               flat;
      for (auto &cell : cells)
        {
          for (auto &corner : cell)
            corner.first *= scale;
          const std::size_t first = parts.size();
          append_parts(cell, number++, parts);
          // a cell that is turned inside out as a whole is still that cell
          double sum = 0., least = 0.;
          for (std::size_t i = first; i < parts.size(); ++i)
            sum += parts[i].volume;
          for (std::size_t i = first; i < parts.size(); ++i)
            {
              parts[i].volume *= sum < 0. ? -1. : 1.;
              least =
                i == first ? parts[i].volume : std::min(least, parts[i].volume);
            }
          if (!(least > 0.) && n_flat++ == 0)
            flat = dealii::Patterns::Tools::to_string(cell.front().first);
        }
      require(n_flat == 0,
              std::to_string(n_flat) + " of its " +
                std::to_string(cells.size()) +
                " cells have no volume or are folded, so that they lie in part "
                "outside of themselves; one has a corner at (" +
                flat + ") m. Make the mesh anew, e.g. optimised by Gmsh");
      return parts;
    }
  } // namespace

  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_volume_mesh(const MeshFile &mesh)
  {
    const auto require = [&](const bool condition, const std::string &what) {
      AssertThrow(
        condition,
        ExcParameter(mesh.section, mesh.entry, mesh.file, what + "."));
    };
    require(mesh.scale > 0.,
            "its scale is " + shortest(mesh.scale) +
              " and must be positive (m per unit of the file)");
    MeshCells<dim> cells = read_mesh_cells<dim>(mesh);
    auto           shape = std::make_unique<VolumeMesh<dim>>(
      sound_parts(cells, mesh.scale, require));
    const std::string place = shape->overlap();
    require(place.empty(),
            "its cells overlap, e.g. at (" + place +
              ") m: that volume would count twice. Let parts of the geometry "
              "meet before they are meshed (in Gmsh: BooleanFragments), or "
              "take regions as bodies of their own");
    return shape;
  }

  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_mesh(const MeshFile &mesh)
  {
    if constexpr (dim == 3)
      if (!mesh.has_cells() && mesh.region.empty())
        return read_surface_mesh(mesh.file,
                                 mesh.scale,
                                 mesh.section,
                                 mesh.entry);
    AssertThrow(mesh.has_cells(),
                ExcParameter(mesh.section,
                             mesh.entry,
                             mesh.file,
                             std::string(
                               dim == 2 ? "a closed surface fills nothing in "
                                          "two dimensions"
                                        : "a surface has no regions") +
                               ". Name a mesh of cells, .msh or .vtk."));
    return read_volume_mesh<dim>(mesh);
  }

  template std::unique_ptr<Shape<2>>
  read_mesh<2>(const MeshFile &);
  template std::unique_ptr<Shape<3>>
  read_mesh<3>(const MeshFile &);
  template std::unique_ptr<Shape<2>>
  read_volume_mesh<2>(const MeshFile &);
  template std::unique_ptr<Shape<3>>
  read_volume_mesh<3>(const MeshFile &);
} // namespace emmy
