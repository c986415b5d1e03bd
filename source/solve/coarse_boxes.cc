#include <deal.II/base/mpi.h>

#include <emmy/solve/coarse_boxes.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

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
  } // namespace

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

    std::vector<unsigned int> box_of(n_columns);
    std::vector<Motion>       motions(n_columns);
    for (unsigned int j = 0; j < n_columns; ++j)
      {
        const Key &key = keys[node_of[j]];
        box_of[j] = std::lower_bound(all.begin(), all.end(), key) - all.begin();
        std::array<double, dim> d;
        for (int c = 0; c < dim; ++c)
          d[c] = 2. * (places_of_nodes[node_of[j]][c] / edge - key[c]) - 1.;
        motions[j] = rigid_motions<dim>(d)[component_of[j]];
        for (double &motion : motions[j])
          motion *= couples[j];
      }

    coarse.reinit(n_modes * all.size());
    amounts.reinit(n_modes * all.size());
    project(matrix, box_of, motions);
  }

  template <int dim>
  void
  CoarseBoxes<dim>::project(const Matrix                    &matrix,
                            const std::vector<unsigned int> &box_of,
                            const std::vector<Motion>       &motions)
  {
    const Epetra_CrsMatrix &entries = matrix.trilinos_matrix();
    const unsigned int      n_rows  = amounts.size();
    first.assign(1, 0);
    boxes.clear();
    products.clear();
    box_of_node.resize(n_owned);
    motions_of_node.resize(n_owned);
    std::vector<double> sums(n_rows * n_rows);
    for (unsigned int node = 0; node < n_owned; ++node)
      {
        for (int i = 0; i < dim; ++i)
          {
            int     length, *columns;
            double *values;
            entries.ExtractMyRowView(dim * node + i, length, values, columns);
            std::size_t place = first.back();
            for (int k = 0; k < length; ++k)
              {
                const unsigned int box = box_of[columns[k]];
                if (place >= boxes.size() || boxes[place] != box)
                  {
                    place = std::find(boxes.begin() + first.back(),
                                      boxes.end(),
                                      box) -
                            boxes.begin();
                    if (place == boxes.size())
                      {
                        boxes.push_back(box);
                        products.push_back(Motions{});
                      }
                  }
                const auto &motion = motions[columns[k]];
                for (unsigned int m = 0; m < n_modes; ++m)
                  products[place][i][m] += values[k] * motion[m];
              }
          }
        for (int i = 0; i < dim; ++i)
          {
            const int own =
              entries.ColMap().LID(entries.RowMap().GID(dim * node + i));
            box_of_node[node]        = box_of[own];
            motions_of_node[node][i] = motions[own];
          }
        first.push_back(boxes.size());
        for (std::size_t k = first[node]; k < first[node + 1]; ++k)
          for (unsigned int m = 0; m < n_modes; ++m)
            for (unsigned int l = 0; l < n_modes; ++l)
              for (int i = 0; i < dim; ++i)
                sums[(n_modes * box_of_node[node] + m) * n_rows +
                     n_modes * boxes[k] + l] +=
                  motions_of_node[node][i][m] * products[k][i][l];
      }
    dealii::Utilities::MPI::sum(
      dealii::ArrayView<const double>(sums.data(), sums.size()),
      matrix.get_mpi_communicator(),
      dealii::ArrayView<double>(sums.data(), sums.size()));

    // boxes whose nodes hardly move would make it singular
    constexpr double relative = 1e-8, absolute = 1e-10;
    double           largest = 0.;
    for (unsigned int i = 0; i < n_rows; ++i)
      largest = std::max(largest, std::abs(sums[i * n_rows + i]));
    for (unsigned int i = 0; i < n_rows; ++i)
      for (unsigned int j = 0; j < n_rows; ++j)
        coarse(i, j) = sums[i * n_rows + j];
    for (unsigned int i = 0; i < n_rows; ++i)
      coarse(i, i) += relative * std::abs(coarse(i, i)) +
                      (largest > 0. ? absolute * largest : 1.);
    coarse.compute_lu_factorization();
  }

  template <int dim>
  void
  CoarseBoxes<dim>::correct(const Vector &r, Vector &y, Vector &rest) const
  {
    const double *in = r.begin();
    amounts          = 0.;
    for (unsigned int node = 0; node < n_owned; ++node)
      for (int c = 0; c < dim; ++c)
        for (unsigned int m = 0; m < n_modes; ++m)
          amounts[n_modes * box_of_node[node] + m] +=
            motions_of_node[node][c][m] * in[dim * node + c];
    dealii::Utilities::MPI::sum(amounts, r.get_mpi_communicator(), amounts);
    coarse.solve(amounts);

    double *out = y.begin(), *left = rest.begin();
    for (unsigned int node = 0; node < n_owned; ++node)
      for (int c = 0; c < dim; ++c)
        {
          double        motion = 0., force = 0.;
          const double *amount = &amounts[n_modes * box_of_node[node]];
          for (unsigned int m = 0; m < n_modes; ++m)
            motion += motions_of_node[node][c][m] * amount[m];
          for (std::size_t k = first[node]; k < first[node + 1]; ++k)
            for (unsigned int m = 0; m < n_modes; ++m)
              force += products[k][c][m] * amounts[n_modes * boxes[k] + m];
          out[dim * node + c]  = motion;
          left[dim * node + c] = in[dim * node + c] - force;
        }
  }

  template class CoarseBoxes<2>;
  template class CoarseBoxes<3>;
} // namespace emmy
