#include <deal.II/base/mpi.h>

#include <emmy/solve/met_nodes.h>
#include <emmy/solve/overlap_rows.h>

#include <algorithm>

namespace emmy
{
  using dealii::types::global_dof_index;

  template <int n>
  std::vector<global_dof_index>
  OverlapRows<n>::meet(const Matrix &matrix)
  {
    AssertThrow(matrix.local_size() % n == 0,
                dealii::ExcMessage("A rank has a part of a node."));
    AssertThrow(graph->RowMap().LinearMap(),
                dealii::ExcMessage("Unknowns of ranks are not in order."));
    const std::vector<global_dof_index> result = met_on_others(*graph, n);
    exchange  = exchange_with_others(matrix, n, result);
    n_own     = matrix.local_size();
    n_others  = n * result.size();
    first_own = n * (std::lower_bound(result.begin(),
                                      result.end(),
                                      matrix.local_range().first / n) -
                     result.begin());
    return result;
  }

  template <int n>
  template <class Number, class What>
  std::vector<Number>
  OverlapRows<n>::hand_over(const What &what) const
  {
    std::map<unsigned int, std::vector<Number>> messages;
    for (const NodeExchange::Neighbour &neighbour : exchange.neighbours())
      for (const unsigned int node : neighbour.own)
        for (int i = 0; i < n; ++i)
          what(n * node + i, messages[neighbour.rank]);
    std::vector<Number> result;
    for (const auto &[rank, message] :
         dealii::Utilities::MPI::some_to_some(communicator, messages))
      {
        (void)rank;
        result.insert(result.end(), message.begin(), message.end());
      }
    return result;
  }

  template <int n>
  bool
  OverlapRows<n>::is_repeated(const unsigned int row) const
  {
    if (row % n == 0)
      return false;
    int length, length_before, *columns, *columns_before;
    graph->ExtractMyRowView(row, length, columns);
    graph->ExtractMyRowView(row - 1, length_before, columns_before);
    return length == length_before &&
           std::equal(columns, columns + length, columns_before);
  }

  template <int n>
  void
  OverlapRows<n>::find_diagonals()
  {
    diagonals.assign(n_own + n_others, nowhere);
    for (unsigned int i = 0; i < diagonals.size(); ++i)
      if (i >= begin() && i < end())
        {
          int length, *in_row;
          graph->ExtractMyRowView(i - begin(), length, in_row);
          for (int k = 0; k < length && diagonals[i] == nowhere; ++k)
            if (column[in_row[k]] == i)
              diagonals[i] = k;
        }
      else
        {
          const unsigned int other = i < begin() ? i : i - n_own;
          for (std::size_t k = first[other]; k < first[other + 1]; ++k)
            if (other_columns[k] == i)
              diagonals[i] = k;
        }
  }

  template <int n>
  bool
  OverlapRows<n>::read(const Matrix &matrix)
  {
    entries      = &matrix.trilinos_matrix();
    communicator = matrix.get_mpi_communicator();
    const bool is_new =
      !graph || graph->DataPtr() != entries->Graph().DataPtr();
    if (is_new)
      {
        // a copy shares what it has: no other pattern can have its place
        graph = std::make_unique<const Epetra_CrsGraph>(entries->Graph());
        const std::vector<global_dof_index> met      = meet(matrix);
        const auto                          place_of = [&](const int unknown) {
          const int own = entries->RowMap().LID(unknown);
          if (own >= 0)
            return begin() + own;
          const auto node =
            std::lower_bound(met.begin(), met.end(), unsigned(unknown / n));
          if (node == met.end() || *node != unsigned(unknown / n))
            return none;
          const unsigned int place = n * (node - met.begin()) + unknown % n;
          return place < begin() ? place : place + n_own;
        };
        column.resize(entries->ColMap().NumMyElements());
        for (unsigned int j = 0; j < column.size(); ++j)
          column[j] = place_of(entries->ColMap().GID(j));
        // a row: how many columns, and which; those of the one before: -1
        const auto rows = hand_over<int>([&](const int i, auto &message) {
          if (is_repeated(i))
            return message.push_back(-1);
          int length, *columns;
          graph->ExtractMyRowView(i, length, columns);
          message.push_back(length);
          for (int k = 0; k < length; ++k)
            message.push_back(graph->ColMap().GID(columns[k]));
        });
        first.assign(1, 0);
        other_columns.clear();
        std::vector<char> others_like_last;
        for (std::size_t i = 0; i < rows.size(); i += 1 + std::max(rows[i], 0))
          {
            const bool is_like = rows[i] < 0;
            if (is_like)
              for (std::size_t k = first[first.size() - 2], end = first.back();
                   k < end;
                   ++k)
                other_columns.push_back(other_columns[k]);
            for (int k = 1; k <= rows[i]; ++k)
              other_columns.push_back(place_of(rows[i + k]));
            first.push_back(other_columns.size());
            others_like_last.push_back(is_like);
          }
        like_last.clear();
        for (unsigned int i = 0; i < n_own; ++i)
          like_last.push_back(is_repeated(i));
        like_last.insert(like_last.begin(),
                         others_like_last.begin(),
                         others_like_last.begin() + begin());
        like_last.insert(like_last.end(),
                         others_like_last.begin() + begin(),
                         others_like_last.end());
        find_diagonals();
      }
    values = hand_over<double>([&](const int i, auto &message) {
      const double *const of_row = (*entries)[i];
      message.insert(message.end(), of_row, of_row + entries->NumMyEntries(i));
    });
    return is_new;
  }

  template <int n>
  const std::vector<double> &
  OverlapRows<n>::of_others(const Vector &vector) const
  {
    from_others.resize(n_others);
    exchange.update(vector.begin(), n, from_others.data());
    return from_others;
  }

  template class OverlapRows<2>;
  template class OverlapRows<3>;
} // namespace emmy
