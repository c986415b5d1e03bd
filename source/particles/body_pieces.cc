#include <deal.II/base/mpi.h>

#include <emmy/particles/body_pieces.h>

#include <boost/pending/disjoint_sets.hpp>

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace emmy
{
  namespace
  {
    /** Cells and the piece that each belongs to, if it is known already. */
    template <int dim>
    using Pieces = std::map<CellKey<dim>, unsigned int>;

    /** Call function(neighbour) for all cells that share a node with one. */
    template <int dim, class Function>
    void
    for_each_neighbour(const CellKey<dim> &cell, const Function &function)
    {
      std::array<int, dim> offset;
      offset.fill(-1);
      for (unsigned int d = 0; d < dim;)
        {
          CellKey<dim> neighbour = cell;
          for (unsigned int c = 0; c < dim; ++c)
            neighbour[c] += offset[c]; // below 0 it wraps, to no cell
          if (neighbour != cell)
            function(neighbour);
          for (d = 0; d < dim && ++offset[d] > 1; ++d)
            offset[d] = -1;
        }
    }

    /** Join the pieces of neighbours; they are numbered anew from 0. */
    template <int dim>
    unsigned int
    join_neighbours(Pieces<dim> &cells, const unsigned int n_before)
    {
      std::vector<unsigned int> rank(n_before), parent(n_before);
      boost::disjoint_sets<unsigned int *, unsigned int *> sets(rank.data(),
                                                                parent.data());
      for (unsigned int i = 0; i < n_before; ++i)
        sets.make_set(i);
      for (const auto &[cell, piece] : cells)
        {
          const unsigned int own = piece;
          for_each_neighbour<dim>(cell, [&](const auto &neighbour) {
            if (const auto found = cells.find(neighbour); found != cells.end())
              sets.union_set(own, found->second);
          });
        }
      std::map<unsigned int, unsigned int> number;
      for (unsigned int i = 0; i < n_before; ++i)
        number.emplace(sets.find_set(i), number.size());
      for (auto &[cell, piece] : cells)
        piece = number.at(sets.find_set(piece));
      return number.size();
    }

    template <int dim>
    bool
    lacks_neighbour(const Pieces<dim> &cells, const CellKey<dim> &cell)
    {
      bool result = false;
      for_each_neighbour<dim>(cell, [&](const auto &neighbour) {
        result = result || cells.count(neighbour) == 0;
      });
      return result;
    }

    /** The pieces of a body from the first rank's view. Collective. */
    template <int dim>
    unsigned int
    n_pieces(Pieces<dim> cells, const MPI_Comm communicator)
    {
      unsigned int n = 0;
      for (auto &[cell, piece] : cells)
        piece = n++;
      n = join_neighbours<dim>(cells, n);
      // numbers: how many pieces, then place and piece of each cell
      std::vector<unsigned int> sent{n};
      for (const auto &[cell, piece] : cells)
        if (lacks_neighbour<dim>(cells, cell))
          {
            sent.insert(sent.end(), cell.begin(), cell.end());
            sent.push_back(piece);
          }
      const auto   all    = dealii::Utilities::MPI::gather(communicator, sent);
      unsigned int result = 0, n_all = 0;
      Pieces<dim>  edges;
      for (const auto &of_rank : all) // none on other ranks
        {
          for (std::size_t i = 1; i < of_rank.size(); i += dim + 1)
            {
              CellKey<dim> cell;
              std::copy_n(&of_rank[i], dim, cell.begin());
              edges[cell] = n_all + of_rank[i + dim];
            }
          n_all += of_rank[0];
        }
      if (!all.empty())
        result = join_neighbours<dim>(edges, n_all);
      return dealii::Utilities::MPI::max(result, communicator);
    }
  } // namespace

  template <int dim>
  std::vector<unsigned int>
  count_pieces(const unsigned int                             n_bodies,
               const BackgroundGrid<dim>                     &grid,
               const FieldLayout                             &layout,
               const dealii::Particles::ParticleHandler<dim> &particles)
  {
    std::vector<Pieces<dim>> cells(n_bodies);
    const unsigned int       body = layout["body"];
    for (const auto &particle : particles)
      cells[static_cast<unsigned int>(particle.get_properties()[body])].emplace(
        grid.key_of(particle.get_surrounding_cell()), 0);
    std::vector<unsigned int> result;
    for (auto &of_body : cells)
      result.push_back(n_pieces<dim>(std::move(of_body), grid.communicator()));
    return result;
  }

#define INSTANTIATE(dim)                                \
  template std::vector<unsigned int> count_pieces<dim>( \
    const unsigned int,                                 \
    const BackgroundGrid<dim> &,                        \
    const FieldLayout &,                                \
    const dealii::Particles::ParticleHandler<dim> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
