#include <emmy/base/exceptions.h>
#include <emmy/output/run_directory.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <system_error>

namespace emmy
{
  namespace
  {
    namespace fs = std::filesystem;

    /** What went wrong and how to mend it; empty if nothing did. */
    struct Problem
    {
      std::string what, remedy;
    };


    /**
     * Remove the files in @p folder whose whole name matches. Returns the
     * first file that could not be removed, or nothing.
     */
    std::string
    remove_matching(const fs::path &folder, const std::string &pattern)
    {
      const std::regex             ours(pattern);
      std::error_code              error;
      std::vector<fs::path>        files;
      fs::directory_iterator       entry(folder, error);
      const fs::directory_iterator end;
      for (; !error && entry != end; entry.increment(error))
        if (std::regex_match(entry->path().filename().string(), ours) &&
            !fs::is_directory(entry->symlink_status()))
          files.push_back(entry->path());
      if (error)
        return folder.string();

      for (const fs::path &file : files)
        if (!fs::remove(file, error) && error)
          return file.string();
      return {};
    }


    /** Remove the checkpoints of a run. Returns what could not be removed. */
    std::string
    remove_checkpoints(const fs::path &folder)
    {
      static const std::regex ours("(damaged-)?step-[0-9]+(\\.new|\\.old)?");
      const fs::path          checkpoints = folder / "checkpoints";
      if (!fs::is_directory(checkpoints))
        return {};
      std::vector<fs::path> old;
      for (const auto &entry : fs::directory_iterator(checkpoints))
        if (std::regex_match(entry.path().filename().string(), ours))
          old.push_back(entry.path());
      std::error_code error;
      for (const fs::path &one : old)
        if (fs::remove_all(one, error); error)
          return one.string();
      fs::remove(checkpoints,
                 error); // fails if something of the user's is left
      return {};
    }


    /** Remove what emmy writes, and nothing else. */
    Problem
    remove_old_run(const fs::path &folder)
    {
      const std::string run_files =
        "(ledger\\.csv|parameters\\.prm|run\\.log|timing\\.json|report\\.html|fields\\.txt|"
        "(particles|grid)(_[0-9]+(\\.[0-9]+)?\\.(p?vtu|csv)|\\.pvd))(\\.new)?";
      std::string    kept     = remove_matching(folder, run_files);
      const fs::path pictures = folder / "pictures";
      if (kept.empty() && fs::is_directory(pictures))
        {
          kept = remove_matching(pictures,
                                 "(energies|balance_error|particles)"
                                 "\\.(gp|png|svg|pdf)|"
                                 "particles_[0-9]+\\.dat|gnuplot\\.log");
          std::error_code ignored; // fails if something of the user's is left
          fs::remove(pictures, ignored);
        }
      if (kept.empty())
        kept = remove_checkpoints(folder);
      if (kept.empty())
        kept = remove_checkpoints(folder / "start");
      std::error_code ignored; // fails if something of the user's is left
      fs::remove(folder / "start", ignored);
      if (kept.empty() && fs::is_directory(folder / "failure"))
        {
          kept = remove_matching(folder / "failure", "cause\\.txt");
          if (kept.empty())
            if (const Problem problem = remove_old_run(folder / "failure");
                !problem.what.empty())
              return problem;
          fs::remove(folder / "failure", ignored);
        }
      if (kept.empty())
        return {};
      return {"<" + kept + "> of the old run cannot be removed",
              "check its permissions, or choose another directory."};
    }


    Problem
    prepare(const std::string &path)
    {
      if (path.empty())
        return {"no folder is given",
                "set a name for Directory in section Output."};

      const fs::path  folder(path);
      std::error_code error;
      fs::create_directories(folder, error);
      if (!fs::is_directory(folder))
        return {"the folder <" + path + "> cannot be created" +
                  (error ? " (" + error.message() + ")" : std::string()),
                "check the spelling of the path, that each part of it is a "
                "folder, and that you may write there."};

      // Only opening a file tells: root may write where permissions forbid
      // it, and a file system may be read-only or full.
      const fs::path probe = folder / ".emmy_can_write_here";
      std::ofstream  file(probe);
      file << "x" << std::flush;
      const bool is_writable = static_cast<bool>(file);
      file.close();
      fs::remove(probe, error);
      if (!is_writable)
        return {"no file can be written in the folder <" + path + ">",
                "check its permissions and the space on the disk, or choose "
                "another directory."};
      return {};
    }


    Problem
    refuse_old_run(const std::string &path)
    {
      if (fs::exists(fs::path(path) / "ledger.csv"))
        return {"the folder <" + path + "> already holds a run",
                "run with --overwrite or `set Overwrite = true` in section "
                "Output to replace it, or choose another directory. A run "
                "that has checkpoints goes on with emmy --restart " +
                  path + "."};
      return {};
    }
  } // namespace


  RunDirectory::RunDirectory(const std::string &path,
                             const bool         overwrite,
                             const MPI_Comm     communicator)
    : RunDirectory(path, overwrite ? Old::removed : Old::refused, communicator)
  {}


  RunDirectory
  RunDirectory::of_run(const std::string &path, const MPI_Comm communicator)
  {
    return RunDirectory(path, Old::kept, communicator);
  }


  RunDirectory::RunDirectory(const std::string &path,
                             const Old          old_run,
                             const MPI_Comm     communicator)
    : directory(path)
  {
    const bool is_first =
      dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
    Problem problem;
    if (is_first)
      try
        {
          problem = prepare(path);
          if (problem.what.empty() && old_run == Old::removed)
            problem = remove_old_run(path);
          else if (problem.what.empty() && old_run == Old::refused)
            problem = refuse_old_run(path);
        }
      catch (const std::filesystem::filesystem_error &error)
        {
          problem = {error.what(),
                     "check the path and its permissions, or choose another "
                     "directory."};
        }
    problem.what   = agree_on_problem(communicator, problem.what);
    problem.remedy = agree_on_problem(communicator, problem.remedy);
    AssertThrow(problem.what.empty(),
                ExcRun("Output directory", problem.what, problem.remedy));

    const bool is_seen = is_first || std::filesystem::is_directory(path);
    throw_together(
      communicator,
      "Output directory",
      is_seen ? std::string()
              : "rank " +
                  std::to_string(
                    dealii::Utilities::MPI::this_mpi_process(communicator)) +
                  " does not see the folder <" + path + "> that rank 0 made",
      "choose a directory on a file system that all ranks share.");
  }


  void
  RunDirectory::remove_frames_from(const unsigned int number) const
  {
    static const std::regex ours(
      "(particles|grid|surfaces)_([0-9]{4,9})(\\.[0-9]+)?\\.(p?vtu|csv)"
      "(\\.new)?");
    std::error_code              error;
    fs::directory_iterator       entry(directory, error);
    const fs::directory_iterator end;
    std::vector<fs::path>        late;
    for (; !error && entry != end; entry.increment(error))
      {
        const std::string name = entry->path().filename().string();
        std::smatch       match;
        if (std::regex_match(name, match, ours) &&
            std::stoul(match[2]) >= number)
          late.push_back(entry->path());
      }
    for (const fs::path &file : late)
      fs::remove(file, error);
  }


  const std::string &
  RunDirectory::path() const
  {
    return directory;
  }


  std::string
  RunDirectory::file(const std::string &name) const
  {
    return (std::filesystem::path(directory) / name).string();
  }
} // namespace emmy
