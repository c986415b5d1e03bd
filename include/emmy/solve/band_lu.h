#ifndef emmy_solve_band_lu_h
#define emmy_solve_band_lu_h

#include <vector>

namespace emmy
{
  /**
   * LU factors of a small matrix whose entries stand near its diagonal, with
   * exchanges of rows (Golub and Van Loan 2013, Matrix computations, sec. 4.3).
   * Each rank has all of it.
   *
   * Cost: 2 n w^2 to 4 n w^2 operations for n rows of width w; a solve takes
   * 4 n w to 6 n w.
   */
  class BandLu
  {
  public:
    /**
     * Zero.
     * @param n     rows
     * @param width how far an entry may be from the diagonal
     */
    void
    reinit(const unsigned int n, const unsigned int width);

    /** Of row i and column j, at most the width away; before factorise(). */
    double &
    operator()(const unsigned int i, const unsigned int j)
    {
      return row(i)[j];
    }

    /** Once. Throws dealii::ExcMessage if the matrix is singular. */
    void
    factorise();

    /** Of A x = b: from b to x. */
    void
    solve(double *x) const;

  private:
    /** Exchanges let a row of U end as far as twice the width away. */
    double *
    row(const unsigned int i)
    {
      return entries.data() + std::size_t(3 * width) * i + width;
    }
    const double *
    row(const unsigned int i) const
    {
      return entries.data() + std::size_t(3 * width) * i + width;
    }
    /** Of row and column k: the largest entry that is left comes there. */
    void
    exchange(const unsigned int k, const unsigned int last);

    unsigned int              width = 0;
    std::vector<double>       entries, factors; ///< U by rows, L by columns
    std::vector<unsigned int> ends;             ///< of the rows of U
    std::vector<unsigned int> exchanged;        ///< with which row
  };
} // namespace emmy

#endif
