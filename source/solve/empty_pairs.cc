#include <emmy/solve/empty_pairs.h>

#include <Epetra_CrsMatrix.h>

#include <algorithm>

namespace emmy
{
  WithoutEmptyPairs::WithoutEmptyPairs(const unsigned int n_components)
    : n(n_components)
  {}

  const Matrix &
  WithoutEmptyPairs::operator()(const Matrix &matrix)
  {
    const Epetra_CrsMatrix &all = matrix.trilinos_matrix();
    AssertThrow(n == 2 || n == 3, dealii::ExcInternalError());
    if (n == 2)
      find_kept<2>(all);
    else
      find_kept<3>(all);
    unsigned int known = 0;
    for (; known < last.size(); ++known)
      {
        // a copy shares what it has: no other graph can have its place
        const bool is_same =
          last[known] && last[known]->all.DataPtr() == all.Graph().DataPtr() &&
          last[known]->is_kept == is_kept;
        if (dealii::Utilities::MPI::min(is_same ? 1 : 0,
                                        matrix.get_mpi_communicator()))
          break;
      }
    if (known > 0)
      std::swap(last[0], last[1]);
    if (known == last.size())
      last[0] = made(all);
    if (n == 2)
      copy<2>(all, *last[0]);
    else
      copy<3>(all, *last[0]);
    return last[0]->matrix;
  }

  template <int n>
  void
  WithoutEmptyPairs::find_kept(const Epetra_CrsMatrix &matrix)
  {
    is_kept.clear();
    is_kept.reserve(matrix.NumMyNonzeros() / (n * n));
    std::array<double *, n> rows;
    for (int row = 0; row < matrix.NumMyRows(); row += n)
      {
        int  length = 0, other = 0;
        int *columns = nullptr;
        for (int c = 0; c < n; ++c)
          {
            matrix.ExtractMyRowView(row + c, length, rows[c], columns);
            AssertThrow((c == 0 || length == other) && length % n == 0,
                        dealii::ExcInternalError());
            other = length;
          }
        const int diagonal = matrix.LCID(matrix.GRID64(row));
        for (int first = 0; first < length; first += n)
          {
            bool is_empty = columns[first] != diagonal;
            for (int c = 0; c < n && is_empty; ++c)
              for (int d = 0; d < n && is_empty; ++d)
                is_empty = rows[c][first + d] == 0.;
            is_kept.push_back(!is_empty);
          }
      }
  }

  std::unique_ptr<WithoutEmptyPairs::Reduced>
  WithoutEmptyPairs::made(const Epetra_CrsMatrix &matrix) const
  {
    const Epetra_CrsGraph &all = matrix.Graph();
    std::vector<int>       lengths, kept;
    const auto             for_each_row = [&](const auto &visit) {
      std::size_t pair = 0;
      for (int row = 0; row < all.NumMyRows(); row += n)
        {
          int  length  = 0;
          int *columns = nullptr;
          all.ExtractMyRowView(row, length, columns);
          kept.clear();
          for (int first = 0; first < length; first += n)
            if (is_kept[pair++])
              kept.insert(kept.end(), columns + first, columns + first + n);
          for (int c = 0; c < n; ++c)
            visit(row + c);
        }
    };
    for_each_row([&](const int) { lengths.push_back(kept.size()); });
    Epetra_CrsGraph graph(Copy,
                          all.RowMap(),
                          all.ColMap(),
                          lengths.data(),
                          /*StaticProfile=*/true);
    for_each_row([&](const int row) {
      graph.InsertMyIndices(row, kept.size(), kept.data());
    });
    graph.FillComplete(all.DomainMap(), all.RangeMap());
    graph.OptimizeStorage();
    auto result = std::make_unique<Reduced>(Reduced{all, is_kept, {}});
    result->matrix.reinit(Epetra_CrsMatrix(Copy, graph),
                          /*copy_values=*/false);
    return result;
  }

  template <int n>
  void
  WithoutEmptyPairs::copy(const Epetra_CrsMatrix &matrix, Reduced &result) const
  {
    const Epetra_CrsMatrix &kept       = result.matrix.trilinos_matrix();
    const char             *first_pair = is_kept.data();
    for (int row = 0; row < matrix.NumMyRows(); row += n)
      {
        const char *end = first_pair;
        for (int c = 0; c < n; ++c)
          {
            int     length = 0, kept_length = 0;
            double *from = nullptr, *to = nullptr;
            matrix.ExtractMyRowView(row + c, length, from);
            kept.ExtractMyRowView(row + c, kept_length, to);
            end = first_pair + length / n;
            for (const char *pair = first_pair; pair < end; ++pair, from += n)
              if (*pair)
                for (int d = 0; d < n; ++d)
                  *to++ = from[d];
          }
        first_pair = end;
      }
  }
} // namespace emmy
