#include <deal.II/grid/grid_in.h>
#include <deal.II/grid/tria.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/particles/mesh_cells.h>

#include <boost/algorithm/string/predicate.hpp>

#include <algorithm>
#include <fstream>
#include <map>

namespace emmy
{
  using dealii::Point;

  namespace
  {
    /** In words. */
    template <int dim>
    std::string
    known_cells()
    {
      return dim == 2 ? "triangles or quadrilaterals with straight edges"
                      : "tetrahedra or hexahedra with straight edges";
    }

    /** A cell, and Gmsh's physical group that it is in; 0: none. */
    template <int dim>
    struct Cells
    {
      std::vector<std::pair<std::vector<MeshCorner<dim>>, unsigned int>> list;
      std::string problem; ///< empty: none
    };

    /** Of Gmsh, by deal.II. */
    template <int dim>
    Cells<dim>
    read_gmsh(const std::string &file)
    {
      Cells<dim> result;
      try
        {
          std::ifstream in(file);
          std::string   first, version, is_binary;
          std::getline(in, first);
          in >> version >> is_binary;
          if (is_binary == "1")
            {
              result.problem = "it is binary; write it as text (ASCII)";
              return result;
            }
          in.seekg(0);
          dealii::Triangulation<dim> grid;
          dealii::GridIn<dim>        reader(grid);
          reader.read_msh(in);
          for (const auto &cell : grid.active_cell_iterators())
            {
              result.list.push_back({{}, cell->material_id()});
              for (const unsigned int v : cell->vertex_indices())
                result.list.back().first.emplace_back(cell->vertex(v),
                                                      cell->vertex_index(v));
            }
        }
      catch (const dealii::ExceptionBase &error)
        {
          const std::string words = message_of(error); // and lists behind
          result.problem          = words.substr(0, words.find('\n'));
        }
      catch (const std::exception &error) // of streams
        {
          result.problem = error.what();
        }
      return result;
    }

    /** What stands in a legacy file of VTK. */
    struct VtkText
    {
      std::vector<Point<3>>                  points;
      std::vector<std::vector<unsigned int>> cells;
      std::vector<unsigned int>              types;

      /** @return what is wrong; empty: nothing */
      std::string
      read(std::istream &in)
      {
        std::string line, word;
        std::getline(in, line);
        if (line.compare(0, 5, "# vtk") != 0)
          return "its first line is no <# vtk DataFile Version ...>";
        std::getline(in, line); // a title
        in >> word;
        if (word != "ASCII")
          return "it is binary; write it as text (ASCII)";
        std::size_t n = 0;
        while (in >> word)
          if (word == "POINTS")
            {
              in >> n >> word;
              points.resize(n);
              for (auto &point : points)
                in >> point[0] >> point[1] >> point[2];
            }
          else if (word == "CELLS")
            read_cells(in);
          else if (word == "CELL_TYPES")
            {
              in >> n;
              types.resize(n);
              for (auto &type : types)
                in >> type;
            }
          else if (word == "CELL_DATA" || word == "POINT_DATA")
            break;
        if (points.empty() || cells.size() != types.size())
          return "it is no whole unstructured grid (POINTS, CELLS, "
                 "CELL_TYPES)";
        for (const auto &cell : cells)
          for (const unsigned int corner : cell)
            if (corner >= points.size())
              return "a cell has the point " + std::to_string(corner) +
                     ", and there are " + std::to_string(points.size());
        return "";
      }

    private:
      void
      read_cells(std::istream &in)
      {
        std::size_t n = 0, n_numbers = 0;
        in >> n >> n_numbers >> std::ws;
        std::string word;
        if (in.peek() == 'O') // from version 5 on: ends, then all corners
          {
            in >> word >> word;
            std::vector<std::size_t> ends(n);
            for (auto &end : ends)
              in >> end;
            in >> word >> word;
            for (std::size_t i = 1; i < n && in; ++i)
              read_numbers(in, ends[i] - ends[i - 1]);
            return;
          }
        for (std::size_t i = 0; i < n && in; ++i)
          {
            std::size_t n_corners = 0;
            in >> n_corners;
            read_numbers(in, n_corners);
          }
      }

      void
      read_numbers(std::istream &in, const std::size_t n)
      {
        auto &cell = cells.emplace_back();
        for (std::size_t i = 0, number = 0; i < n && in >> number; ++i)
          cell.push_back(number);
      }
    };

    /** Of VTK; cells of fewer dimensions do not count. */
    template <int dim>
    Cells<dim>
    read_vtk(const std::string &file)
    {
      Cells<dim>    result;
      VtkText       text;
      std::ifstream in(file);
      result.problem = text.read(in);
      if (!result.problem.empty())
        return result;
      // number of VTK's type, and deal.II's order of its corners
      const std::map<unsigned int, std::vector<unsigned int>> known =
        dim == 2
          ? std::map<unsigned int, std::vector<unsigned int>>{{5, {0, 1, 2}},
                                                              {8, {0, 1, 2, 3}},
                                                              {9, {0, 1, 3, 2}}}
          : std::map<unsigned int, std::vector<unsigned int>>{
              {10, {0, 1, 2, 3}},
              {11, {0, 1, 2, 3, 4, 5, 6, 7}},
              {12, {0, 1, 3, 2, 4, 5, 7, 6}}};
      for (std::size_t c = 0; c < text.cells.size(); ++c)
        {
          const unsigned int type  = text.types[c];
          const auto         found = known.find(type);
          if (found == known.end() && type > (dim == 2 ? 9 : 12))
            result.problem = "it has cells of VTK's type " +
                             std::to_string(type) + ", and emmy knows " +
                             known_cells<dim>();
          if (found == known.end() ||
              text.cells[c].size() != found->second.size())
            continue;
          result.list.push_back({{}, 0});
          for (const unsigned int v : found->second)
            {
              const unsigned int corner = text.cells[c][v];
              Point<dim>         place;
              for (unsigned int d = 0; d < dim; ++d)
                place[d] = text.points[corner][d];
              result.list.back().first.emplace_back(place, corner);
            }
        }
      return result;
    }

    template <int dim>
    Cells<dim>
    read_cells(const std::string &file)
    {
      auto cells = boost::iends_with(file, ".msh") ? read_gmsh<dim>(file)
                                                   : read_vtk<dim>(file);
      if (cells.problem.empty() && cells.list.empty())
        cells.problem = "it has no cells of " + std::to_string(dim) +
                        " dimensions, " + known_cells<dim>();
      return cells;
    }

    /** The numbers of Gmsh's physical groups of cells, by their names. */
    std::map<std::string, unsigned int>
    groups_in(const std::string &file, const unsigned int dim)
    {
      std::map<std::string, unsigned int> result;
      std::ifstream                       in(file);
      unsigned int                        n = 0;
      for (std::string line; std::getline(in, line);)
        if (line.compare(0, 14, "$PhysicalNames") == 0)
          {
            for (in >> n; n > 0 && in; --n)
              {
                unsigned int dimension = 0, number = 0;
                std::string  name;
                in >> dimension >> number;
                std::getline(in, name);
                const auto first = name.find('"'), last = name.rfind('"');
                if (dimension == dim && first < last)
                  result[name.substr(first + 1, last - first - 1)] = number;
              }
            break;
          }
      return result;
    }

    /** Keep the cells of a group; throws by @p require if there are none. */
    template <int dim, class Require>
    void
    choose_region(const MeshFile &mesh,
                  Cells<dim>     &cells,
                  const Require  &require)
    {
      const auto               groups = groups_in(mesh.file, dim);
      std::vector<std::string> names;
      for (const auto &group : groups)
        names.push_back(group.first);
      const auto found = groups.find(mesh.region);
      const bool is_number =
        mesh.region.find_first_not_of("0123456789") == std::string::npos;
      const unsigned int number = found != groups.end() ? found->second
                                  : is_number ? std::stoul(mesh.region)
                                              : 0;
      auto              &list   = cells.list;
      if (found != groups.end() || is_number)
        list.erase(std::remove_if(list.begin(),
                                  list.end(),
                                  [&](const auto &cell) {
                                    return cell.second != number;
                                  }),
                   list.end());
      require((found != groups.end() || is_number) && !list.empty(),
              "it has no cells of a physical group <" + mesh.region +
                ">. Its groups of " + std::to_string(dim) +
                " dimensions are named: " +
                (names.empty() ? "none" : join(names)));
    }
  } // namespace

  bool
  MeshFile::has_cells() const
  {
    return boost::iends_with(file, ".msh") || boost::iends_with(file, ".vtk");
  }

  template <int dim>
  MeshCells<dim>
  read_mesh_cells(const MeshFile &mesh)
  {
    const auto require = [&](const bool condition, const std::string &what) {
      AssertThrow(
        condition,
        ExcParameter(mesh.section, mesh.entry, mesh.file, what + "."));
    };
    require(std::ifstream(mesh.file).good(),
            "there is no such file to read; a name without / in front counts "
            "from the folder in which emmy is started");
    Cells<dim> cells = read_cells<dim>(mesh.file);
    if (!cells.problem.empty())
      {
        constexpr int other = 5 - dim;
        require(!read_cells<other>(mesh.file).problem.empty(),
                "its cells have " + std::to_string(other) +
                  " dimensions, and the scene has " + std::to_string(dim) +
                  (dim == 3 ? ". Mesh the volume, not its surface alone; a "
                              "closed surface is read from STL, OBJ or PLY"
                            : ". Mesh a section in the plane of x and y"));
        require(false,
                "it cannot be read: " + cells.problem +
                  ". Meshes are read from Gmsh (.msh of version 2 or 4.1, as "
                  "text) and VTK (.vtk, legacy, as text), of " +
                  known_cells<dim>());
      }
    if (!mesh.region.empty())
      choose_region(mesh, cells, require);
    MeshCells<dim> result;
    for (auto &cell : cells.list)
      result.push_back(std::move(cell.first));
    return result;
  }

  template MeshCells<2>
  read_mesh_cells<2>(const MeshFile &);
  template MeshCells<3>
  read_mesh_cells<3>(const MeshFile &);
} // namespace emmy
