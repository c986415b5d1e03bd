#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/whole_file.h>
#include <emmy/output/data_file.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace emmy
{
  namespace
  {
    /** The names of all components, which is that of their field. */
    std::vector<std::string>
    component_names(const std::vector<FieldDescription> &fields,
                    const unsigned int                   dim)
    {
      std::vector<std::string> names;
      for (const FieldDescription &field : fields)
        {
          const unsigned int n = field.n_components;
          AssertThrow(n == 1 || n == dim || n == 9,
                      ExcRun("Output field <" + field.name + ">",
                             "it has " + std::to_string(n) + " components",
                             "give it 1 (scalar), " + std::to_string(dim) +
                               " (vector) or 9 (tensor)."));
          AssertThrow(!field.name.empty() &&
                        std::find(names.begin(), names.end(), field.name) ==
                          names.end(),
                      ExcRun("Output field <" + field.name + ">",
                             "its name is empty or taken by another field",
                             "give every field of a file a name of its own."));
          names.insert(names.end(), n, field.name);
        }
      return names;
    }


    /** Which of all components are integers. */
    std::vector<bool>
    integer_components(const std::vector<FieldDescription> &fields)
    {
      std::vector<bool> result;
      for (const FieldDescription &field : fields)
        result.insert(result.end(), field.n_components, field.is_integer);
      return result;
    }


    /** Insert @p addition behind the first line that has @p mark. */
    void
    insert_behind(std::string       &text,
                  const std::string &mark,
                  const std::string &addition)
    {
      const auto line = text.find(mark);
      AssertThrow(line != std::string::npos, dealii::ExcInternalError());
      text.insert(text.find('\n', line) + 1, addition);
    }


    /** The element that describes an array of integers, up to its end. */
    std::string
    integer_array(const std::string &element, const std::string &name)
    {
      return "    <" + element + " type=\"Int64\" Name=\"" + name +
             "\" format=\"ascii\"";
    }


    /**
     * List the fields of the files @p basename in fields.txt, unless they
     * are there already. What went wrong; empty if nothing did.
     */
    std::string
    list_fields(const std::string                   &directory,
                const std::string                   &basename,
                const std::vector<FieldDescription> &fields)
    {
      const std::string filename =
        (std::filesystem::path(directory) / "fields.txt").string();
      const std::string  heading = basename + ".pvd";
      std::ifstream      present(filename);
      std::ostringstream out;
      for (std::string line; std::getline(present, line);)
        if (line == heading)
          return {};
        else
          out << line << "\n";

      out << heading << "\n" << std::string(heading.size(), '-') << "\n";
      for (const FieldDescription &field : fields)
        {
          out << field.name << " [" << (field.unit.empty() ? "1" : field.unit)
              << "]";
          if (field.n_components > 1)
            out << (field.n_components == 9 ? " (tensor)" : " (vector)");
          out << ": " << field.description << "\n";
        }
      out << "\n";
      return write_whole_file(filename, out.str());
    }
  } // namespace


  template <int patch_dim, int dim>
  DataFile<patch_dim, dim>::DataFile(std::vector<FieldDescription> fields)
    : fields(std::move(fields))
    , is_integer(integer_components(this->fields))
    , integers(std::count(is_integer.begin(), is_integer.end(), true))
  {
    Assert(patch_dim == 0 || integers.empty(), dealii::ExcNotImplemented());
    const auto all_names = component_names(this->fields, dim);
    for (unsigned int c = 0; c < all_names.size(); ++c)
      if (!is_integer[c])
        names.push_back(all_names[c]);
  }


  template <int patch_dim, int dim>
  unsigned int
  DataFile<patch_dim, dim>::n_values() const
  {
    return is_integer.size();
  }


  template <int patch_dim, int dim>
  void
  DataFile<patch_dim, dim>::reserve(const std::size_t n_patches)
  {
    patches.reserve(n_patches);
  }


  template <int patch_dim, int dim>
  void
  DataFile<patch_dim, dim>::add_point(
    const dealii::Point<dim>              &position,
    const dealii::ArrayView<const double> &values)
  {
    Assert(patch_dim == 0, dealii::ExcMessage("This file holds cells."));
    add_cell({{position}}, values);
  }


  template <int patch_dim, int dim>
  void
  DataFile<patch_dim, dim>::add_cell(
    const std::array<dealii::Point<dim>, n_vertices> &vertices,
    const dealii::ArrayView<const double>            &values)
  {
    AssertDimension(values.size(), n_vertices * n_values());

    patches.emplace_back();
    dealii::DataOutBase::Patch<patch_dim, dim> &patch = patches.back();
    patch.patch_index                                 = patches.size() - 1;
    if constexpr (patch_dim > 0)
      patch.reference_cell = dealii::ReferenceCells::get_hypercube<patch_dim>();
    // An array in deal.II 9.4, a std::array in 9.6.
    std::copy(vertices.begin(), vertices.end(), std::begin(patch.vertices));

    patch.data.reinit(names.size(), n_vertices);
    for (unsigned int v = 0; v < n_vertices; ++v)
      for (unsigned int c = 0, real = 0, integer = 0; c < n_values(); ++c)
        {
          const double value = values[v * n_values() + c];
          if (is_integer[c])
            integers[integer++].push_back(static_cast<std::int64_t>(value));
          else
            patch.data(real++, v) = static_cast<float>(value);
        }
  }


  template <int patch_dim, int dim>
  std::string
  DataFile<patch_dim, dim>::write(const std::string &directory,
                                  const std::string &basename,
                                  const unsigned int frame,
                                  const double       time,
                                  const MPI_Comm     communicator)
  {
    dealii::DataOutBase::VtkFlags flags(time, frame);
    // The name of the enumeration differs between deal.II 9.4 and 9.6. The
    // best compression takes ten times as long and saves a few percent.
    flags.compression_level = decltype(flags.compression_level)::best_speed;
    for (const FieldDescription &field : fields)
      if (!field.unit.empty())
        flags.physical_units[field.name] = field.unit;
    this->set_flags(flags);

    const unsigned int n_ranks =
      dealii::Utilities::MPI::n_mpi_processes(communicator);
    const unsigned int rank =
      dealii::Utilities::MPI::this_mpi_process(communicator);
    const std::string stem =
      basename + "_" + dealii::Utilities::int_to_string(frame, 4) + ".";
    const auto file_of = [&stem](const unsigned int r) {
      return stem + std::to_string(r) + ".vtu";
    };
    const auto path = [&directory](const std::string &file) {
      return (std::filesystem::path(directory) / file).string();
    };

    std::string problem = write_whole_file(path(file_of(rank)), piece());
    if (rank == 0 && problem.empty())
      {
        std::vector<std::string> pieces;
        for (unsigned int r = 0; r < n_ranks; ++r)
          pieces.push_back(file_of(r));
        problem = write_whole_file(path(stem + "pvtu"), record(pieces));
      }
    if (rank == 0 && problem.empty())
      problem = list_fields(directory, basename, fields);
    throw_together(communicator, "Output", problem, file_remedy);
    return stem + "pvtu";
  }


  template <int patch_dim, int dim>
  std::string
  DataFile<patch_dim, dim>::piece() const
  {
    std::ostringstream out;
    this->write_vtu(out);
    std::string  text = out.str();
    unsigned int i    = 0;
    for (const FieldDescription &field : fields)
      if (field.is_integer)
        {
          std::string array = integer_array("DataArray", field.name) + ">\n";
          for (const std::int64_t value : integers[i++])
            array += std::to_string(value) + ' ';
          insert_behind(text, "<PointData", array + "\n    </DataArray>\n");
        }
    return text;
  }


  template <int patch_dim, int dim>
  std::string
  DataFile<patch_dim, dim>::record(const std::vector<std::string> &pieces) const
  {
    std::ostringstream out;
    this->write_pvtu_record(out, pieces);
    std::string text = out.str();
    for (const FieldDescription &field : fields)
      if (field.is_integer)
        insert_behind(text,
                      "<PPointData",
                      integer_array("PDataArray", field.name) + "/>\n");
    return text;
  }


  template <int patch_dim, int dim>
  const std::vector<dealii::DataOutBase::Patch<patch_dim, dim>> &
  DataFile<patch_dim, dim>::get_patches() const
  {
    return patches;
  }


  template <int patch_dim, int dim>
  std::vector<std::string>
  DataFile<patch_dim, dim>::get_dataset_names() const
  {
    return names;
  }


  template <int patch_dim, int dim>
  std::vector<typename DataFile<patch_dim, dim>::Range>
  DataFile<patch_dim, dim>::get_nonscalar_data_ranges() const
  {
    std::vector<Range> ranges;
    unsigned int       first = 0;
    for (const FieldDescription &field : fields)
      {
        namespace Kind = dealii::DataComponentInterpretation;
        if (field.n_components > 1)
          ranges.emplace_back(first,
                              first + field.n_components - 1,
                              field.name,
                              field.n_components == 9
                                ? Kind::component_is_part_of_tensor
                                : Kind::component_is_part_of_vector);
        first += field.is_integer ? 0 : field.n_components;
      }
    return ranges;
  }


  template class DataFile<0, 2>;
  template class DataFile<0, 3>;
  template class DataFile<1, 2>;
  template class DataFile<2, 2>;
  template class DataFile<2, 3>;
  template class DataFile<3, 3>;
} // namespace emmy
