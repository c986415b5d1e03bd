#include <emmy/grid/window.h>

#include <algorithm>
#include <cstdint>

namespace emmy
{
  namespace
  {
    template <int dim>
    void
    make_unique(std::vector<CellKey<dim>> &places)
    {
      std::sort(places.begin(), places.end());
      places.erase(std::unique(places.begin(), places.end()), places.end());
    }

    /** Call function(place) for all places from first to last. */
    template <int dim, class Function>
    void
    for_each_place(const CellKey<dim> &first,
                   const CellKey<dim> &last,
                   const Function     &function)
    {
      CellKey<dim> place = first;
      for (unsigned int d = 0; d < dim;)
        {
          function(place);
          for (d = 0; d < dim && ++place[d] > last[d]; ++d)
            place[d] = first[d];
        }
    }

    /** The last block of 2^level cells that reaches into the grid. */
    template <int dim>
    CellKey<dim>
    last_block(const std::vector<unsigned int> &n_cells,
               const unsigned int               level)
    {
      CellKey<dim> last;
      for (unsigned int d = 0; d < dim; ++d)
        last[d] = (n_cells[d] - 1) >> level;
      return last;
    }

    template <int dim>
    std::vector<CellKey<dim>>
    all_blocks(const std::vector<unsigned int> &n_cells,
               const unsigned int               level)
    {
      std::vector<CellKey<dim>> blocks;
      for_each_place<dim>({},
                          last_block<dim>(n_cells, level),
                          [&](const auto &block) { blocks.push_back(block); });
      make_unique<dim>(blocks);
      return blocks;
    }

    /** The same cells in blocks twice as large. */
    template <int dim>
    void
    coarsen(std::vector<CellKey<dim>> &blocks)
    {
      for (auto &block : blocks)
        for (unsigned int &place : block)
          place >>= 1;
      make_unique<dim>(blocks);
    }

    /** A thin grid must not be filled with cells that stick out of it. */
    unsigned int
    highest_level(const std::vector<unsigned int> &n_cells)
    {
      const unsigned int least =
        *std::min_element(n_cells.begin(), n_cells.end());
      unsigned int level = 0;
      while ((1u << level) <= least)
        ++level;
      return level;
    }

    /**
     * Larger blocks, until there are not too many of them, or the grid is too
     * thin. @return the level
     */
    template <int dim>
    unsigned int
    limit(std::vector<CellKey<dim>> &blocks,
          unsigned int               level,
          const unsigned int         highest)
    {
      for (; blocks.size() > Window<dim>::most_blocks && level < highest;
           ++level)
        coarsen<dim>(blocks);
      return level;
    }
  } // namespace

  template <int dim>
  Window<dim>
  Window<dim>::whole(const std::vector<unsigned int> &n_cells)
  {
    Window window;
    window.n_cells = n_cells;
    while (
      std::all_of(n_cells.begin(), n_cells.end(), [&](const unsigned int n) {
        return n % (2u << window.refinements) == 0;
      }))
      ++window.refinements;
    window.places = all_blocks<dim>(n_cells, window.refinements);
    return window;
  }

  template <int dim>
  Window<dim>
  Window<dim>::around(const std::vector<Place>        &cells,
                      const std::vector<unsigned int> &n_cells,
                      const MPI_Comm                   communicator)
  {
    const unsigned int highest = highest_level(n_cells),
                       first   = std::min(least_level, highest);
    // each rank makes few blocks before they are exchanged
    std::vector<Place> occupied;
    for (Place block : cells)
      {
        for (unsigned int &place : block)
          place >>= first;
        if (occupied.empty() || occupied.back() != block)
          occupied.push_back(block);
      }
    make_unique<dim>(occupied);
    const Place        last = last_block<dim>(n_cells, first);
    std::vector<Place> own;
    for (const Place &block : occupied)
      {
        Place from, to;
        for (unsigned int d = 0; d < dim; ++d)
          {
            from[d] = block[d] > 0 ? block[d] - 1 : 0;
            to[d]   = std::min(block[d] + 1, last[d]);
          }
        for_each_place<dim>(from, to, [&](const Place &place) {
          own.push_back(place);
        });
      }
    make_unique<dim>(own);
    const unsigned int own_level = limit<dim>(own, first, highest),
                       common_level =
                         dealii::Utilities::MPI::max(own_level, communicator);
    for (unsigned int level = own_level; level < common_level; ++level)
      coarsen<dim>(own);

    Window window;
    window.n_cells = n_cells;
    for (const auto &blocks :
         dealii::Utilities::MPI::all_gather(communicator, own))
      window.places.insert(window.places.end(), blocks.begin(), blocks.end());
    make_unique<dim>(window.places);
    window.refinements = limit<dim>(window.places, common_level, highest);
    if (window.places.empty())
      window.places.push_back({});

    std::uint64_t n_all = 1;
    for (const unsigned int place :
         last_block<dim>(n_cells, window.refinements))
      n_all *= place + 1;
    if (2 * window.places.size() > n_all)
      window.places = all_blocks<dim>(n_cells, window.refinements);
    return window;
  }

  template <int dim>
  bool
  Window<dim>::has_surroundings_of(const Place &cell) const
  {
    Place first, last;
    for (unsigned int d = 0; d < dim; ++d)
      {
        first[d] = (cell[d] > 0 ? cell[d] - 1 : 0) >> refinements;
        last[d]  = std::min(cell[d] + 1, n_cells[d] - 1) >> refinements;
      }
    bool is_there = true;
    for_each_place<dim>(first, last, [&](const Place &block) {
      is_there =
        is_there && std::binary_search(places.begin(), places.end(), block);
    });
    return is_there;
  }

  template class Window<2>;
  template class Window<3>;
} // namespace emmy
