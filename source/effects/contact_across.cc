#include <emmy/effects/body_contact.h>
#include <emmy/effects/moving_places.h>

#include <algorithm>

namespace emmy
{
  namespace
  {
    constexpr unsigned int none = std::numeric_limits<unsigned int>::max();
  } // namespace

  // The derivative of BodyContact across pairs of particles.

  namespace
  {
    /** Add W E, E by motion, to rows [dim a + i]. */
    template <int dim, class ByMotion>
    void
    add_rows(const std::vector<double>     &weights,
             const ByMotion                &E,
             std::vector<PointMotion<dim>> &rows)
    {
      constexpr unsigned int n = dim + 1;
      for (unsigned int a = 0; a < weights.size() / n; ++a)
        for (unsigned int i = 0; i < dim; ++i)
          {
            PointMotion<dim> &row = rows[dim * a + i];
            for (unsigned int l = 0; l < n; ++l)
              for (unsigned int c = 0; c < dim * n; ++c)
                row[c] += weights[n * a + l] * E[n * i + l][c];
          }
    }

    /** Subtract rows W of some columns. */
    template <int dim>
    void
    subtract_products(const std::vector<PointMotion<dim>> &rows,
                      const std::vector<double>           &columns,
                      const unsigned int                   first_row,
                      const unsigned int                   first_column,
                      dealii::FullMatrix<double>          &matrix)
    {
      constexpr unsigned int n = dim + 1;
      for (unsigned int r = 0; r < rows.size(); ++r)
        {
          const PointMotion<dim> &row = rows[r];
          double *entry = &matrix(dim * first_row + r, dim * first_column);
          for (unsigned int b = 0; b < columns.size() / n; ++b)
            for (unsigned int j = 0; j < dim; ++j, ++entry)
              for (unsigned int m = 0; m < n; ++m)
                *entry -= row[n * j + m] * columns[n * b + m];
        }
    }

    /** Subtract W E c at some nodes. */
    template <int dim, class ByMotion>
    void
    subtract_share(const std::vector<double> &weights,
                   const ByMotion            &E,
                   const PointMotion<dim>    &c,
                   const unsigned int        *nodes,
                   std::vector<double>       &share)
    {
      constexpr unsigned int n = dim + 1;
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int l = 0; l < n; ++l)
          {
            double sum = 0.;
            for (unsigned int m = 0; m < dim * n; ++m)
              sum += E[n * i + l][m] * c[m];
            for (unsigned int a = 0; a < weights.size() / n; ++a)
              share[unknown<dim>(nodes[a], i)] -= weights[n * a + l] * sum;
          }
    }

    template <class ByMotion>
    ByMotion
    times(const ByMotion &A, const ByMotion &B)
    {
      ByMotion result{};
      for (unsigned int i = 0; i < A.size(); ++i)
        for (unsigned int k = 0; k < A.size(); ++k)
          for (unsigned int j = 0; j < A.size(); ++j)
            result[i][j] += A[i][k] * B[k][j];
      return result;
    }
  } // namespace

  template <int dim>
  void
  BodyContact<dim>::add_across(const StepData<dim>                    &step,
                               const std::vector<FollowedMotion<dim>> &followed,
                               const PairMatrices &derivatives,
                               Matrix             &jacobian) const
  {
    const ActiveGrid<dim> &active = *step.start.active;
    std::vector<double> share(step.moving ? dim * active.n_local_nodes() : 0);
    dealii::FullMatrix<double>    matrix;
    std::vector<PointMotion<dim>> rows;
    std::vector<unsigned int>     acting;
    for (const Clique &clique : cliques)
      {
        acting.clear();
        for (const unsigned int k : clique.pairs)
          if (derivatives.of_pair[k] != none)
            acting.push_back(k);
        if (acting.empty())
          continue;
        const unsigned int *nodes   = active.coupled_nodes(clique.coupled);
        const ParticlePair &any     = candidates.pairs[acting.front()];
        const unsigned int  n_first = where[any.first].n_nodes(),
                           n_all    = n_first + where[any.second].n_nodes();
        matrix.reinit(dim * n_all, dim * n_all);
        for (const unsigned int row : {1u, 0u})
          {
            // rows of one particle, columns of the other
            const auto of = [&](const unsigned int k, const unsigned int side) {
              const ParticlePair &pair = candidates.pairs[k];
              return side == 0 ? pair.first : pair.second;
            };
            const unsigned int column = 1 - row;
            if (row == 0) // those of a column follow one another
              std::stable_sort(acting.begin(),
                               acting.end(),
                               [&](const auto k, const auto l) {
                                 return of(k, column) < of(l, column);
                               });
            const unsigned int first_row    = row == 0 ? 0 : n_first,
                               first_column = row == 0 ? n_first : 0;
            for (std::size_t n = 0; n < acting.size(); ++n)
              {
                const unsigned int i = of(acting[n], row),
                                   j = of(acting[n], column);
                if (n == 0 || of(acting[n - 1], column) != j)
                  rows.assign(dim * (row == 0 ? n_first : n_all - n_first),
                              PointMotion<dim>{});
                if (is_mine(i))
                  {
                    const auto &E =
                      derivatives.matrices[derivatives.of_pair[acting[n]]]
                        .of[row][column];
                    add_rows<dim>(where[i].weights,
                                  step.moving ? times(E, followed[j].by_nodes)
                                              : E,
                                  rows);
                    if (step.moving)
                      subtract_share<dim>(where[i].weights,
                                          E,
                                          followed[j].shift,
                                          nodes + first_row,
                                          share);
                  }
                if (n + 1 == acting.size() || of(acting[n + 1], column) != j)
                  subtract_products<dim>(
                    rows, where[j].weights, first_row, first_column, matrix);
              }
          }
        active.graph().add(nodes, matrix, jacobian);
      }
    if (step.moving)
      step.moving->add_to_share(share);
  }

  template void
  BodyContact<2>::add_across(const StepData<2> &,
                             const std::vector<FollowedMotion<2>> &,
                             const PairMatrices &,
                             Matrix &) const;
  template void
  BodyContact<3>::add_across(const StepData<3> &,
                             const std::vector<FollowedMotion<3>> &,
                             const PairMatrices &,
                             Matrix &) const;
} // namespace emmy
