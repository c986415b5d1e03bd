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
  node_of(const CellKey<dim> &cell,
          const unsigned int  vertex,
          const unsigned int  span)
  {
    CellKey<dim> result = cell;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] += span * ((vertex >> d) & 1);
    return result;
  }

  template <int dim>
  unsigned int
  layers_between(const CellKey<dim> &node,
                 const CellKey<dim> &cell,
                 const unsigned int  span)
  {
    int result = 0;
    for (unsigned int d = 0; d < dim; ++d)
      {
        const int across = int(node[d]) - int(cell[d]);
        result = std::max(result, std::max(-across, across - int(span)));
      }
    return result;
  }

  template <int dim>
  std::array<double, (1 << dim)>
  continued(const CellKey<dim> &cell,
            const CellKey<dim> &node,
            const unsigned int  span)
  {
    std::array<double, (1 << dim)> values;
    values.fill(1.);
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double across = (double(node[d]) - double(cell[d])) / span;
        for (unsigned int v = 0; v < values.size(); ++v)
          values[v] *= (v >> d) & 1 ? across : 1. - across;
      }
    return values;
  }

  template <int dim>
  CellKey<dim>
  block_of(const CellKey<dim> &cell, const unsigned int span)
  {
    CellKey<dim> result = cell;
    for (unsigned int &component : result)
      component -= component % span;
    return result;
  }

#define INSTANTIATE(dim)                                                       \
  template CellKey<dim> further<dim>(const CellKey<dim> &,                     \
                                     const std::array<unsigned int, dim> &);   \
  template CellKey<dim> node_of<dim>(const CellKey<dim> &,                     \
                                     const unsigned int,                       \
                                     const unsigned int);                      \
  template unsigned int layers_between<dim>(const CellKey<dim> &,              \
                                            const CellKey<dim> &,              \
                                            const unsigned int);               \
  template std::array<double, (1 << dim)> continued<dim>(const CellKey<dim> &, \
                                                         const CellKey<dim> &, \
                                                         const unsigned int);  \
  template CellKey<dim> block_of<dim>(const CellKey<dim> &, const unsigned int);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
