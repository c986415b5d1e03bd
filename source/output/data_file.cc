#include <emmy/base/exceptions.h>
#include <emmy/output/data_file.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace emmy
{
  namespace
  {
    /**
     * What the names of a field's components end in; one empty string if the
     * field is written under its own name. Empty for a number of components
     * that we do not know.
     */
    std::vector<std::string>
    suffixes(const unsigned int n_components, const unsigned int dim)
    {
      if (n_components == 1 || n_components == dim)
        return std::vector<std::string>(n_components, "");
      if (n_components == 4 && dim == 2)
        return {"_xx", "_yy", "_xy", "_zz"};
      if (n_components == 6)
        return {"_xx", "_yy", "_zz", "_xy", "_xz", "_yz"};
      if (n_components == 9)
        return {"_xx", "_xy", "_xz", "_yx", "_yy", "_yz", "_zx", "_zy", "_zz"};
      return {};
    }


    /** The names of all components, after checking them. */
    std::vector<std::string>
    component_names(const std::vector<FieldDescription> &fields,
                    const unsigned int                   dim)
    {
      std::vector<std::string> names;
      for (const FieldDescription &field : fields)
        {
          const auto endings = suffixes(field.n_components, dim);
          AssertThrow(!endings.empty(),
                      ExcRun("Output field <" + field.name + ">",
                             "it has " + std::to_string(field.n_components) +
                               " components",
                             "give it 1 (scalar), " + std::to_string(dim) +
                               " (vector), " + (dim == 2 ? "4, " : "") +
                               "6 (symmetric tensor) or 9 (tensor)."));
          AssertThrow(!field.name.empty() &&
                        std::find(names.begin(),
                                  names.end(),
                                  field.name + endings[0]) == names.end(),
                      ExcRun("Output field <" + field.name + ">",
                             "its name is empty or taken by another field",
                             "give every field of a file a name of its own."));
          for (const std::string &ending : endings)
            names.push_back(field.name + ending);
        }
      return names;
    }


    /**
     * List the fields of the files @p basename in fields.txt, unless they
     * are there already.
     */
    void
    list_fields(const std::string                   &directory,
                const std::string                   &basename,
                const std::vector<FieldDescription> &fields,
                const unsigned int                   dim)
    {
      const auto filename = std::filesystem::path(directory) / "fields.txt";
      const std::string heading = basename + ".pvd";
      std::ifstream     present(filename);
      for (std::string line; std::getline(present, line);)
        if (line == heading)
          return;

      std::ofstream out(filename, std::ios::app);
      out << heading << "\n" << std::string(heading.size(), '-') << "\n";
      for (const FieldDescription &field : fields)
        {
          out << field.name << " [" << (field.unit.empty() ? "1" : field.unit)
              << "]";
          const auto endings = suffixes(field.n_components, dim);
          if (!endings[0].empty())
            for (std::size_t i = 0; i < endings.size(); ++i)
              out << (i == 0 ? " (" : ", ") << endings[i]
                  << (i + 1 == endings.size() ? ")" : "");
          else if (endings.size() > 1)
            out << " (vector)";
          out << ": " << field.description << "\n";
        }
      out << "\n" << std::flush;
      AssertThrow(out, dealii::ExcFileNotOpen(filename.string()));
    }
  } // namespace


  template <int patch_dim, int dim>
  DataFile<patch_dim, dim>::DataFile(std::vector<FieldDescription> fields)
    : fields(std::move(fields))
    , names(component_names(this->fields, dim))
  {}


  template <int patch_dim, int dim>
  unsigned int
  DataFile<patch_dim, dim>::n_values() const
  {
    return names.size();
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

    patch.data.reinit(n_values(), n_vertices);
    for (unsigned int v = 0; v < n_vertices; ++v)
      for (unsigned int c = 0; c < n_values(); ++c)
        patch.data(c, v) = static_cast<float>(values[v * n_values() + c]);
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
      for (const std::string &ending : suffixes(field.n_components, dim))
        if (!field.unit.empty())
          flags.physical_units[field.name + ending] = field.unit;
    this->set_flags(flags);

    std::string file, problem;
    try
      {
        file = this->write_vtu_with_pvtu_record(
          (std::filesystem::path(directory) / "").string(),
          basename,
          frame,
          communicator,
          4);
        if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
          list_fields(directory, basename, fields, dim);
      }
    catch (const std::exception &)
      {
        problem = "frame " + std::to_string(frame) + " of <" + basename +
                  "> cannot be written to the folder <" + directory + ">";
      }
    throw_together(communicator,
                   "Output",
                   problem,
                   "check that the folder exists, may be written to, and "
                   "that the disk is not full.");
    return file;
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
        if (field.n_components == dim)
          ranges.emplace_back(
            first,
            first + dim - 1,
            field.name,
            dealii::DataComponentInterpretation::component_is_part_of_vector);
        first += field.n_components;
      }
    return ranges;
  }


  template class DataFile<0, 2>;
  template class DataFile<0, 3>;
  template class DataFile<2, 2>;
  template class DataFile<3, 3>;
} // namespace emmy
