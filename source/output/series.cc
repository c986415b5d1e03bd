#include <emmy/base/exceptions.h>
#include <emmy/output/series.h>

#include <deal.II/base/data_out_base.h>

#include <filesystem>
#include <fstream>

namespace emmy
{
  Series::Series(const std::string &directory,
                 const std::string &basename,
                 const MPI_Comm     communicator)
    : filename(
        (std::filesystem::path(directory) / (basename + ".pvd")).string())
    , communicator(communicator)
  {}


  void
  Series::add(const double time, const std::string &file)
  {
    frames.emplace_back(time, file);

    std::string problem;
    if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
      {
        // Written aside and renamed: a viewer never meets half a file.
        const std::string aside = filename + ".new";
        std::ofstream     out(aside);
        if (out)
          dealii::DataOutBase::write_pvd_record(out, frames);
        out.close();
        std::error_code error;
        if (out)
          std::filesystem::rename(aside, filename, error);
        if (!out || error)
          problem = "the file <" + filename + "> cannot be written";
      }
    throw_together(communicator,
                   "Output",
                   problem,
                   "check that its folder exists, may be written to, and "
                   "that the disk is not full.");
  }


} // namespace emmy
