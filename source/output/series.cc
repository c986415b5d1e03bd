#include <emmy/base/exceptions.h>
#include <emmy/base/whole_file.h>
#include <emmy/output/series.h>

#include <deal.II/base/data_out_base.h>

#include <filesystem>
#include <sstream>

namespace emmy
{
  Series::Series(const std::string  &directory,
                 const std::string  &basename,
                 const MPI_Comm      communicator,
                 std::vector<Entry> *of_run)
    : filename(
        (std::filesystem::path(directory) / (basename + ".pvd")).string())
    , communicator(communicator)
    , frames(of_run ? *of_run : own_frames)
  {}


  void
  Series::add(const double time, const std::string &file)
  {
    frames.emplace_back(time, file);
    write();
  }


  void
  Series::write() const
  {
    if (frames.empty())
      return;
    std::string problem;
    if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
      {
        std::ostringstream text;
        dealii::DataOutBase::write_pvd_record(text, frames);
        problem = write_whole_file(filename, text.str());
      }
    throw_together(communicator, "Output", problem, file_remedy);
  }
} // namespace emmy
