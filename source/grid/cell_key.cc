#include <emmy/grid/cell_key.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  CellKey<dim>
  further(const CellKey<dim> &key, const std::array<unsigned int, dim> &n_cells)
  {
    CellKey<dim> result = key;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] += n_cells[d];
    return result;
  }

  template <int dim>
  CellKey<dim>
  node_of(const CellKey<dim> &cell, const unsigned int vertex)
  {
    CellKey<dim> result = cell;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] += (vertex >> d) & 1;
    return result;
  }

  template <int dim>
  unsigned int
  layers_between(const CellKey<dim> &node, const CellKey<dim> &cell)
  {
    int result = 0;
    for (unsigned int d = 0; d < dim; ++d)
      {
        const int across = int(node[d]) - int(cell[d]);
        result           = std::max(result, std::max(-across, across - 1));
      }
    return result;
  }

  template <int dim>
  std::array<double, (1 << dim)>
  continued(const CellKey<dim> &cell, const CellKey<dim> &node)
  {
    std::array<double, (1 << dim)> values;
    values.fill(1.);
    for (unsigned int d = 0; d < dim; ++d)
      {
        const int across = int(node[d]) - int(cell[d]);
        for (unsigned int v = 0; v < values.size(); ++v)
          values[v] *= (v >> d) & 1 ? across : 1 - across;
      }
    return values;
  }

#define INSTANTIATE(dim)                                                     \
  template CellKey<dim> further<dim>(const CellKey<dim> &,                   \
                                     const std::array<unsigned int, dim> &); \
  template CellKey<dim> node_of<dim>(const CellKey<dim> &,                   \
                                     const unsigned int);                    \
  template unsigned int layers_between<dim>(const CellKey<dim> &,            \
                                            const CellKey<dim> &);           \
  template std::array<double, (1 << dim)> continued<dim>(                    \
    const CellKey<dim> &, const CellKey<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
