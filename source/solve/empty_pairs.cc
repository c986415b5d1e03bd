#include <emmy/solve/empty_pairs.h>

#include <Epetra_CrsMatrix.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    /** The rows of this rank, one after the other. */
    struct Rows
    {
      int    *first, *columns; ///< where each row begins; columns of entries
      double *values;          ///< of entries

      /** @param matrix whose pattern is finished */
      explicit Rows(const Epetra_CrsMatrix &matrix)
      {
        AssertThrow(matrix.ExtractCrsDataPointers(first, columns, values) == 0,
                    dealii::ExcInternalError());
      }

      int
      length(const int row) const
      {
        return first[row + 1] - first[row];
      }
    };
  } // namespace

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
    is_kept.resize(matrix.NumMyNonzeros() / (n * n));
    char      *kept = is_kept.data();
    const Rows all(matrix);
    for (int row = 0; row < matrix.NumMyRows(); row += n)
      {
        const int length = all.length(row);
        for (int c = 0; c < n; ++c)
          AssertThrow(all.length(row + c) == length && length % n == 0,
                      dealii::ExcInternalError());
        const double *values   = all.values + all.first[row];
        const int    *columns  = all.columns + all.first[row];
        const int     diagonal = matrix.LCID(matrix.GRID64(row));
        for (int first = 0; first < length; first += n)
          {
            bool is_empty = columns[first] != diagonal;
            for (int c = 0; c < n && is_empty; ++c)
              for (int d = 0; d < n && is_empty; ++d)
                is_empty = values[c * length + first + d] == 0.;
            *kept++ = !is_empty;
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
    const Rows  all(matrix), kept(result.matrix.trilinos_matrix());
    const char *first_pair = is_kept.data();
    for (int row = 0; row < matrix.NumMyRows(); row += n)
      {
        const char *const end = first_pair + all.length(row) / n;
        for (int c = 0; c < n; ++c)
          {
            const double *from = all.values + all.first[row + c];
            double       *to   = kept.values + kept.first[row + c];
            for (const char *pair = first_pair; pair < end; ++pair, from += n)
              if (*pair)
                for (int d = 0; d < n; ++d)
                  *to++ = from[d];
          }
        first_pair = end;
      }
  }
} // namespace emmy
