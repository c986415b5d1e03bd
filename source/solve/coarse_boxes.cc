#include <deal.II/base/mpi.h>

#include <emmy/math/node_numbers.h>
#include <emmy/solve/coarse_boxes.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Whether each row couples anything, as 1 or 0. */
    Epetra_Vector
    coupling_rows(const Epetra_CrsMatrix &matrix)
    {
      Epetra_Vector result(matrix.RowMap());
      for (int i = 0; i < matrix.NumMyRows(); ++i)
        {
          int     length, *columns;
          double *values;
          matrix.ExtractMyRowView(i, length, values, columns);
          const int own = matrix.ColMap().LID(matrix.RowMap().GID(i));
          for (int k = 0; k < length; ++k)
            if (columns[k] != own && values[k] != 0.)
              {
                result[i] = 1.;
                break;
              }
        }
      return result;
    }

    /** A vector over the rows of a matrix, over its columns. */
    Epetra_Vector
    on_columns(const Epetra_CrsMatrix &matrix, const Epetra_Vector &rows)
    {
      Epetra_Vector       result(matrix.ColMap());
      const Epetra_Import import(matrix.ColMap(), rows.Map());
      result.Import(rows, import, Insert);
      return result;
    }

    /** How the rigid motions of a box move a node at d from its centre. */
    template <int dim>
    std::array<std::array<double, dim *(dim + 1) / 2>, dim>
    rigid_motions(const std::array<double, dim> &d)
    {
      std::array<std::array<double, dim *(dim + 1) / 2>, dim> result{};
      for (int c = 0; c < dim; ++c)
        result[c][c] = 1.;
      if constexpr (dim == 2)
        {
          result[0][2] = -d[1];
          result[1][2] = d[0];
        }
      else if constexpr (dim == 3)
        for (int a = 0; a < 3; ++a)
          {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            result[b][3 + a] = -d[c];
            result[c][3 + a] = d[b];
          }
      return result;
    }

    /** Row by row along the longest extent: neighbours stand near each other.
     */
    template <std::size_t dim>
    void
    order(std::vector<std::array<int, dim>> &keys)
    {
      std::array<int, dim> extent{};
      for (unsigned int c = 0; c < dim; ++c)
        {
          const auto [low, high] =
            std::minmax_element(keys.begin(),
                                keys.end(),
                                [c](const auto &a, const auto &b) {
                                  return a[c] < b[c];
                                });
          extent[c] = keys.empty() ? 0 : (*high)[c] - (*low)[c];
        }
      std::array<unsigned int, dim> directions;
      std::iota(directions.begin(), directions.end(), 0u);
      std::stable_sort(directions.begin(),
                       directions.end(),
                       [&](const unsigned int a, const unsigned int b) {
                         return extent[a] > extent[b];
                       });
      std::sort(keys.begin(), keys.end(), [&](const auto &a, const auto &b) {
        for (const unsigned int c : directions)
          if (a[c] != b[c])
            return a[c] < b[c];
        return false;
      });
    }

    /** What the kernel of correct() works on. */
    template <int dim>
    struct Correction
    {
      static constexpr unsigned int n_modes = dim * (dim + 1) / 2;

      unsigned int        n_nodes;
      const unsigned int *box_of_node;
      const double       *motions; ///< by node, mode and direction
      const std::size_t  *first;
      const unsigned int *boxes;
      const double       *products; ///< as motions
      const double       *amounts;
      const double       *in;
      double             *out, *left;
    };

    /** sum += modes times their amounts. */
    template <int dim>
    EMMY_INLINE void
    add_modes(const double                    *modes,
              const double                    *amounts,
              typename NodeNumbers<dim>::type &sum)
    {
      for (unsigned int m = 0; m < Correction<dim>::n_modes; ++m)
        sum += read_node<dim>(modes + dim * m) * amounts[m];
    }

    template <int dim>
    EMMY_INLINE void
    correct_nodes(const Correction<dim> &at)
    {
      constexpr unsigned int n_modes = Correction<dim>::n_modes;
      for (unsigned int node = 0; node < at.n_nodes; ++node)
        {
          typename NodeNumbers<dim>::type motion{}, force{};
          add_modes<dim>(at.motions + dim * n_modes * node,
                         at.amounts + n_modes * at.box_of_node[node],
                         motion);
          for (std::size_t k = at.first[node]; k < at.first[node + 1]; ++k)
            add_modes<dim>(at.products + dim * n_modes * k,
                           at.amounts + n_modes * at.boxes[k],
                           force);
          for (unsigned int c = 0; c < dim; ++c)
            {
              at.out[dim * node + c]  = motion[c];
              at.left[dim * node + c] = at.in[dim * node + c] - force[c];
            }
        }
    }
    /** Neighbours in a row of the matrix, and the motions of all columns. */
    template <int dim>
    struct RowPart
    {
      int           n;
      const double *entries;
      const int    *columns;
      const double *motions; ///< by column and mode
    };

    /** sum += entries times the motions of their columns, by mode. */
    template <int dim>
    EMMY_INLINE void
    add_motions(const RowPart<dim> &part, double *sum)
    {
      constexpr int n_modes = Correction<dim>::n_modes;
      double        sums[n_modes]{};
      for (int k = 0; k < part.n; ++k)
        for (int m = 0; m < n_modes; ++m)
          sums[m] +=
            part.entries[k] * part.motions[n_modes * part.columns[k] + m];
      for (int m = 0; m < n_modes; ++m)
        sum[m] += sums[m];
    }
  } // namespace

  namespace box_kernels
  {
    // no templates: those have no clones
    EMMY_CLONES void
    add(const RowPart<2> &part, double *sum)
    {
      add_motions(part, sum);
    }
    EMMY_CLONES void
    add(const RowPart<3> &part, double *sum)
    {
      add_motions(part, sum);
    }
    EMMY_CLONES void
    correct(const Correction<2> &at)
    {
      correct_nodes<2>(at);
    }
    EMMY_CLONES void
    correct(const Correction<3> &at)
    {
      correct_nodes<3>(at);
    }
  } // namespace box_kernels

  template <int dim>
  void
  CoarseBoxes<dim>::make(const Matrix &matrix, const NodePlaces &places)
  {
    constexpr unsigned int most_rows = 600;

    const auto &[where, spacing]         = places;
    const Epetra_CrsMatrix &entries      = matrix.trilinos_matrix();
    const MPI_Comm          communicator = matrix.get_mpi_communicator();
    n_owned                              = entries.NumMyRows() / dim;

    const Epetra_Vector coordinates =
      on_columns(entries, *where.trilinos_vector()(0));
    const Epetra_Vector couples = on_columns(entries, coupling_rows(entries));
    const Epetra_Map   &columns = entries.ColMap();

    // the nodes of the columns; the columns of a node need not stand together
    const unsigned int          n_columns = columns.NumMyElements();
    std::map<int, unsigned int> index_of;
    std::vector<unsigned int>   node_of(n_columns), component_of(n_columns);
    std::vector<std::array<double, dim>> places_of_nodes;
    for (unsigned int j = 0; j < n_columns; ++j)
      {
        const int  gid  = columns.GID(j);
        const auto node = index_of.emplace(gid / dim, index_of.size()).first;
        node_of[j]      = node->second;
        component_of[j] = gid % dim;
        places_of_nodes.resize(index_of.size());
        places_of_nodes[node_of[j]][component_of[j]] = coordinates[j];
      }
    const unsigned int n_known = places_of_nodes.size();

    // boxes that have a node of any rank, in the order of their keys
    double edge =
      std::max(6., std::ceil(std::pow(matrix.m() / dim / 100., 1. / dim))) *
      spacing;
    std::vector<Key> keys(n_known), all;
    for (;; edge *= 1.2)
      {
        std::set<Key> ours;
        for (unsigned int node = 0; node < n_known; ++node)
          {
            for (int c = 0; c < dim; ++c)
              keys[node][c] =
                static_cast<int>(std::floor(places_of_nodes[node][c] / edge));
            ours.insert(keys[node]);
          }
        std::set<Key> known;
        for (const auto &of_rank : dealii::Utilities::MPI::all_gather(
               communicator, std::vector<Key>(ours.begin(), ours.end())))
          known.insert(of_rank.begin(), of_rank.end());
        if (n_modes * known.size() > most_rows)
          continue;
        all.assign(known.begin(), known.end());
        break;
      }
    order(all);
    std::map<Key, unsigned int> place_of;
    for (const Key &key : all)
      place_of.emplace(key, place_of.size());

    std::vector<unsigned int> box_of(n_columns);
    std::vector<Motion>       motions(n_columns);
    for (unsigned int j = 0; j < n_columns; ++j)
      {
        const Key &key = keys[node_of[j]];
        box_of[j]      = place_of.at(key);
        std::array<double, dim> d;
        for (int c = 0; c < dim; ++c)
          d[c] = 2. * (places_of_nodes[node_of[j]][c] / edge - key[c]) - 1.;
        motions[j] = rigid_motions<dim>(d)[component_of[j]];
        for (double &motion : motions[j])
          motion *= couples[j];
      }

    multiply(matrix, box_of, motions);
    project(all.size(), communicator);
  }

  template <int dim>
  void
  CoarseBoxes<dim>::multiply(const Matrix                    &matrix,
                             const std::vector<unsigned int> &box_of,
                             const std::vector<Motion>       &motions)
  {
    const Epetra_CrsMatrix &entries = matrix.trilinos_matrix();
    first.assign(1, 0);
    boxes.clear();
    products.clear();
    box_of_node.resize(n_owned);
    motions_of_node.assign(n_owned + 1, Motions{});
    for (unsigned int node = 0; node < n_owned; ++node)
      {
        for (int i = 0; i < dim; ++i)
          {
            int     length, *columns;
            double *values;
            entries.ExtractMyRowView(dim * node + i, length, values, columns);
            for (int k = 0; k < length;)
              {
                // neighbours in the same box stand together
                const unsigned int box = box_of[columns[k]];
                Motion             sum{};
                const int          begin = k;
                while (k < length && box_of[columns[k]] == box)
                  ++k;
                box_kernels::add(RowPart<dim>{k - begin,
                                              values + begin,
                                              columns + begin,
                                              motions.front().data()},
                                 sum.data());
                const auto place =
                  std::find(boxes.begin() + first.back(), boxes.end(), box) -
                  boxes.begin();
                if (place == static_cast<std::ptrdiff_t>(boxes.size()))
                  {
                    boxes.push_back(box);
                    products.push_back(Motions{});
                  }
                for (unsigned int m = 0; m < n_modes; ++m)
                  products[place][m][i] += sum[m];
              }
            const int own =
              entries.ColMap().LID(entries.RowMap().GID(dim * node + i));
            box_of_node[node] = box_of[own];
            for (unsigned int m = 0; m < n_modes; ++m)
              motions_of_node[node][m][i] = motions[own][m];
          }
        first.push_back(boxes.size());
      }
    products.push_back(Motions{});
  }

  template <int dim>
  void
  CoarseBoxes<dim>::project(const unsigned int n_boxes,
                            const MPI_Comm     communicator)
  {
    unsigned int farthest = 0; // of two boxes that meet
    for (unsigned int node = 0; node < n_owned; ++node)
      for (std::size_t k = first[node]; k < first[node + 1]; ++k)
        farthest = std::max(farthest,
                            std::max(boxes[k], box_of_node[node]) -
                              std::min(boxes[k], box_of_node[node]));
    farthest = dealii::Utilities::MPI::max(farthest, communicator);

    const unsigned int n_rows = n_modes * n_boxes,
                       width  = n_modes * (farthest + 1) - 1;
    std::vector<double> sums(std::size_t(2 * width + 1) * n_rows);
    const auto          entry = [&](const unsigned int i,
                           const unsigned int j) -> double          &{
      return sums[std::size_t(2 * width) * i + width + j];
    };
    for (unsigned int node = 0; node < n_owned; ++node)
      for (std::size_t k = first[node]; k < first[node + 1]; ++k)
        for (unsigned int m = 0; m < n_modes; ++m)
          for (unsigned int l = 0; l < n_modes; ++l)
            for (int i = 0; i < dim; ++i)
              entry(n_modes * box_of_node[node] + m, n_modes * boxes[k] + l) +=
                motions_of_node[node][m][i] * products[k][l][i];
    dealii::Utilities::MPI::sum(
      dealii::ArrayView<const double>(sums.data(), sums.size()),
      communicator,
      dealii::ArrayView<double>(sums.data(), sums.size()));

    // boxes whose nodes hardly move would make it singular
    constexpr double relative = 1e-8, absolute = 1e-10;
    double           largest = 0.;
    for (unsigned int i = 0; i < n_rows; ++i)
      largest = std::max(largest, std::abs(entry(i, i)));
    coarse.reinit(n_rows, width);
    for (unsigned int i = 0; i < n_rows; ++i)
      {
        const unsigned int begin = i > width ? i - width : 0,
                           end   = std::min(n_rows, i + width + 1);
        for (unsigned int j = begin; j < end; ++j)
          coarse(i, j) = entry(i, j);
        coarse(i, i) += relative * std::abs(entry(i, i)) +
                        (largest > 0. ? absolute * largest : 1.);
      }
    coarse.factorise();
    amounts.resize(n_rows);
  }

  template <int dim>
  void
  CoarseBoxes<dim>::correct(const Vector &r, Vector &y, Vector &rest) const
  {
    const double *in = r.begin();
    std::fill(amounts.begin(), amounts.end(), 0.);
    for (unsigned int node = 0; node < n_owned; ++node)
      {
        const Motions &motions = motions_of_node[node];
        double *const  amount  = &amounts[n_modes * box_of_node[node]];
        for (unsigned int m = 0; m < n_modes; ++m)
          for (int c = 0; c < dim; ++c)
            amount[m] += motions[m][c] * in[dim * node + c];
      }
    dealii::Utilities::MPI::sum(amounts, r.get_mpi_communicator(), amounts);
    coarse.solve(amounts.data());

    box_kernels::correct(Correction<dim>{n_owned,
                                         box_of_node.data(),
                                         motions_of_node.front().front().data(),
                                         first.data(),
                                         boxes.data(),
                                         products.front().front().data(),
                                         amounts.data(),
                                         in,
                                         y.begin(),
                                         rest.begin()});
  }

  template class CoarseBoxes<2>;
  template class CoarseBoxes<3>;
} // namespace emmy
