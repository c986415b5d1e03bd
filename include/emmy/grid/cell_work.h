#ifndef emmy_grid_cell_work_h
#define emmy_grid_cell_work_h

namespace emmy
{
  /**
   * What a cell costs in a step, by which cells are distributed over the ranks:
   * a point 10, a cell that holds points as much as fifteen of them besides,
   * for the solves and the matrices, and an empty cell of the window next to
   * nothing. Measured: doc/scaling.md. Whole numbers, which are the same in
   * each run, so that a run that is repeated or restarted is distributed in the
   * same way.
   */
  inline unsigned int
  work_of_cell(const unsigned int n_points)
  {
    return n_points == 0 ? 1 : 150 + 10 * n_points;
  }
} // namespace emmy

#endif
