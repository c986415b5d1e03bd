#ifndef emmy_output_data_file_h
#define emmy_output_data_file_h

#include <deal.II/base/array_view.h>
#include <deal.II/base/data_out_base.h>
#include <deal.II/base/geometry_info.h>
#include <deal.II/base/mpi.h>
#include <deal.II/base/point.h>

#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace emmy
{
  /**
   * One quantity of an output file.
   *
   * The number of components says what it is, and how its plain doubles are
   * ordered:
   *  - 1: a scalar;
   *  - dim: a vector, which ParaView sees as one;
   *  - 9: a tensor by rows: xx, xy, xz, yx, ..., which ParaView sees as one;
   *    also in plane strain, and of symmetric tensors.
   */
  struct FieldDescription
  {
    std::string  name;             ///< in the file
    unsigned int n_components = 1; ///< 1, 3 or 9
    std::string  unit;             ///< such as "Pa"; empty: dimensionless
    std::string  description;      ///< one line
    /** A scalar to be written as 64-bit integer, not in single precision;
     * only for points. Exact up to 2^53, as it is passed as a double. */
    bool is_integer = false;
  };


  /**
   * One frame of output for ParaView or VisIt: points (patch_dim = 0) or
   * cells (patch_dim = dim) with named values at the points or vertices. Each
   * rank adds what it owns, which may be nothing, then all call write().
   *
   * Made anew for each frame by the run loop; costs about 200 bytes a point.
   * deal.II writes values in single precision, which is exact for integers up
   * to 2^24. Fields that are integers, such as ids, are put into its text as
   * arrays of type Int64.
   */
  template <int patch_dim, int dim>
  class DataFile : public dealii::DataOutInterface<patch_dim, dim>
  {
  public:
    /** Of a cell. */
    static constexpr unsigned int n_vertices =
      dealii::GeometryInfo<patch_dim>::vertices_per_cell;

    /**
     * Throws ExcRun for a number of components that FieldDescription does not
     * list, and for a name that is empty or not unique.
     * @pre integers are scalars of points
     */
    explicit DataFile(std::vector<FieldDescription> fields);

    /** Sum of the components of all fields: the values that a point needs. */
    unsigned int
    n_values() const;

    /** Room for so many points or cells; only a matter of speed. */
    void
    reserve(const std::size_t n_patches);

    /**
     * Add a particle. Only for patch_dim = 0.
     * @param values n_values() numbers in the order of the fields.
     */
    void
    add_point(const dealii::Point<dim>              &position,
              const dealii::ArrayView<const double> &values);

    /**
     * Add a cell with linear, bilinear or trilinear geometry and fields.
     * @param vertices in the order of dealii::GeometryInfo: x fastest.
     * @param values   n_values() numbers for the first vertex, then for the
     *                 second, and so on.
     */
    void
    add_cell(const std::array<dealii::Point<dim>, n_vertices> &vertices,
             const dealii::ArrayView<const double>            &values);

    /**
     * Collective: write basename_FFFF.R.vtu on each rank R and, on rank 0,
     * basename_FFFF.pvtu that joins them; also list the fields in fields.txt,
     * once. Each is whole or absent. Throws ExcRun on all ranks if one cannot
     * be written.
     *
     * @param directory an existing folder
     * @param frame     FFFF, the number of the picture
     * @param time      of this frame, s; stored in the file
     * @return the name of the .pvtu without the folder, for Series::add().
     */
    std::string
    write(const std::string &directory,
          const std::string &basename,
          const unsigned int frame,
          const double       time,
          const MPI_Comm     communicator);

  private:
    using Range = std::tuple<
      unsigned int,
      unsigned int,
      std::string,
      dealii::DataComponentInterpretation::DataComponentInterpretation>;

    const std::vector<dealii::DataOutBase::Patch<patch_dim, dim>> &
    get_patches() const override;

    std::vector<std::string>
    get_dataset_names() const override;

    std::vector<Range>
    get_nonscalar_data_ranges() const override;

    /** What deal.II writes of this rank, and the integers. */
    std::string
    piece() const;

    /** The file that joins those of all ranks. */
    std::string
    record(const std::vector<std::string> &pieces) const;

    const std::vector<FieldDescription> fields;
    std::vector<std::string>            names;       ///< of what deal.II writes
    std::vector<bool>                   is_integer;  ///< each value of a point
    std::vector<std::vector<std::int64_t>> integers; ///< by field and point
    std::vector<dealii::DataOutBase::Patch<patch_dim, dim>> patches;
  };
} // namespace emmy

#endif
