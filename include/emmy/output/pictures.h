#ifndef emmy_output_pictures_h
#define emmy_output_pictures_h

#include <emmy/base/surface.h>
#include <emmy/output/particle_picture.h>

#include <deal.II/base/point.h>

#include <string>
#include <vector>

namespace emmy
{
  /**
   * Pictures of a run, drawn with gnuplot at its end, in the folder
   * `pictures` of the run:
   *  - energies.png: the energies in ledger.csv against time;
   *  - balance_error.png: |balance_error| relative to the initial energy (to
   *    the largest, if the run starts from rest without load);
   *  - forces_NAME.png: the force on a tool against its path, if it moves;
   *  - particles.png: all snapshots, coloured by a value, with colours from
   *    the 1st to the 99th percentile of all values of all snapshots.
   *
   * The scripts stay beside the pictures to be changed and run by hand. One
   * object on one rank, used by the run loop. A picture is worth no run: what
   * goes wrong here is reported by draw(), and nothing is thrown.
   */
  class Pictures
  {
  public:
    /**
     * @param directory of the run, which exists and will hold ledger.csv
     * @param title     printed above the pictures; may be empty
     */
    Pictures(const std::string &directory, const std::string &title);

    /**
     * Keep the particles at @p time (s) for the picture of the particles, in
     * the file particles_NN.dat.
     *
     * @param positions    of all particles of all ranks, m
     * @param values       one for each, in the unit that draw() is told
     * @param lower,upper  corners of the background grid, m
     * @param n_cells      of the grid in each of the dim directions
     * @pre the same dim and grid at each call
     */
    template <int dim>
    void
    add_snapshot(const double                           time,
                 const std::vector<dealii::Point<dim>> &positions,
                 const std::vector<double>             &values,
                 const dealii::Point<dim>              &lower,
                 const dealii::Point<dim>              &upper,
                 const std::vector<unsigned int>       &n_cells);

    /**
     * Show surfaces in the snapshot that was added last, in the file
     * surfaces_NN.dat; none: nothing is written.
     */
    template <int dim>
    void
    add_surfaces(const std::vector<Surface<dim>> &surfaces);

    /**
     * Write the scripts and run gnuplot on them.
     *
     * @param value_label what the values of the snapshots are, with the unit;
     *                    gnuplot's enhanced text (a^b is a superscript)
     * @return one line for each thing that went wrong, for the log; empty if
     *         all pictures were drawn
     */
    std::vector<std::string>
    draw(const std::string &value_label);

    /** What the pictures remember of the snapshots, for recall(). */
    std::vector<double>
    memory() const;

    /** Go on after snapshots of before, whose files are still there. */
    void
    recall(const std::vector<double> &memory);

  private:
    /** Names of the columns of the ledger; empty if it cannot be read. */
    std::vector<std::string>
    ledger_columns() const;

    /** Find what of the grid is shown, and all that panels share. */
    void
    arrange_particles(const std::string &value_label);

    /** Note that a file could not be written. */
    void
    cannot_write(const std::string &file);

    const std::string        directory;
    const std::string        folder; ///< of the pictures
    const std::string        title;
    ParticlePicture          particles;
    std::vector<std::string> warnings;

    /** What the particles of all snapshots need, m. */
    dealii::Point<3> grid_lower, grid_upper, lowest, highest;
  };
} // namespace emmy

#endif
