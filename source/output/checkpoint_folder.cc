#include <emmy/base/exceptions.h>
#include <emmy/base/sealed_file.h>
#include <emmy/base/whole_file.h>
#include <emmy/output/checkpoint_folder.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <regex>
#include <system_error>

namespace emmy
{
  namespace
  {
    namespace fs = std::filesystem;
    using namespace dealii::Utilities::MPI;

    std::string
    part_name(const unsigned int rank)
    {
      return "particles." + std::to_string(rank);
    }

    std::string
    numbers(const std::vector<std::uint64_t> &list)
    {
      return {reinterpret_cast<const char *>(list.data()),
              list.size() * sizeof(std::uint64_t)};
    }

    /** Nothing that goes wrong here loses anything. */
    void
    remove_folder(const std::string &path)
    {
      std::error_code ignored;
      fs::remove_all(path, ignored);
    }
  } // namespace

  CheckpointFolder::CheckpointFolder(const std::string &directory,
                                     const MPI_Comm     communicator)
    : folder((fs::path(directory) / "checkpoints").string())
    , communicator(communicator)
    , is_first(this_mpi_process(communicator) == 0)
  {}

  std::string
  CheckpointFolder::path_of(const unsigned int step) const
  {
    char name[32];
    std::snprintf(name, sizeof(name), "step-%08u", step);
    return (fs::path(folder) / name).string();
  }

  std::vector<unsigned int>
  CheckpointFolder::steps() const
  {
    static const std::regex      ours("step-([0-9]{8,10})");
    std::vector<unsigned int>    result;
    std::error_code              error;
    fs::directory_iterator       entry(folder, error);
    const fs::directory_iterator end;
    for (; !error && entry != end; entry.increment(error))
      {
        const std::string name = entry->path().filename().string();
        std::smatch       match;
        if (std::regex_match(name, match, ours))
          result.push_back(std::stoul(match[1]));
      }
    std::sort(result.begin(), result.end());
    return result;
  }

  std::string
  CheckpointFolder::write(const unsigned int                   step,
                          const std::string                   &head,
                          const std::vector<std::string_view> &parts,
                          const unsigned int                   n_kept) const
  {
    const std::string aside = path_of(step) + ".new";
    std::string       problem;
    if (is_first)
      {
        remove_folder(aside);
        std::error_code error;
        fs::create_directories(aside, error);
        if (error)
          problem = cannot_write(aside, error.value());
      }
    problem = agree_on_problem(communicator, problem);
    if (!problem.empty())
      return problem;

    const auto in = [&aside](const std::string &name) {
      return (fs::path(aside) / name).string();
    };
    std::uint64_t checksum = 0;
    problem = write_sealed_file(in(part_name(this_mpi_process(communicator))),
                                format,
                                parts,
                                checksum);
    const std::vector<std::uint64_t> checksums = gather(communicator, checksum);
    problem = agree_on_problem(communicator, problem);
    if (is_first && problem.empty())
      {
        const std::string table =
          numbers({checksums.size()}) + numbers(checksums);
        problem =
          write_sealed_file(in("head"), format, {table, head}, checksum);
        if (problem.empty())
          problem = flush_to_disk(aside);
        if (problem.empty())
          problem = put_in_place(step, n_kept);
      }
    problem = agree_on_problem(communicator, problem);
    if (is_first && !problem.empty())
      remove_folder(aside);
    return problem;
  }

  std::string
  CheckpointFolder::put_in_place(const unsigned int step,
                                 const unsigned int n_kept) const
  {
    const std::string path = path_of(step), old = path + ".old";
    std::error_code   error;
    remove_folder(old);
    std::error_code ignored;
    if (fs::exists(path, ignored))
      fs::rename(path, old, error);
    if (!error)
      fs::rename(path + ".new", path, error);
    if (error)
      return cannot_write(path, error.value());
    const std::string problem = flush_to_disk(folder);
    if (!problem.empty())
      return problem;
    remove_folder(old);
    std::vector<unsigned int> there = steps();
    for (std::size_t i = 0; i + n_kept < there.size(); ++i)
      if (there[i] < step) // the one just written stays in any case
        remove_folder(path_of(there[i]));
    return {};
  }

  ReadCheckpoint
  CheckpointFolder::read_newest(const unsigned int latest) const
  {
    std::vector<unsigned int> there;
    if (is_first)
      there = steps();
    there = broadcast(communicator, there);
    ReadCheckpoint           result;
    std::vector<std::string> passed_over;
    for (auto step = there.rbegin(); step != there.rend(); ++step)
      if (*step <= latest)
        {
          ReadCheckpoint candidate;
          candidate.step            = *step;
          candidate.path            = path_of(*step);
          const std::string problem = read(candidate);
          if (problem.empty())
            {
              result = std::move(candidate);
              break;
            }
          passed_over.push_back(problem);
        }
    result.passed_over = passed_over;
    return result;
  }

  std::string
  CheckpointFolder::read(ReadCheckpoint &checkpoint) const
  {
    const auto in = [&checkpoint](const std::string &name) {
      return (fs::path(checkpoint.path) / name).string();
    };
    std::vector<std::uint64_t> checksums;
    std::string                problem;
    if (is_first)
      {
        SealedFile file = read_sealed_file(in("head"), format);
        problem         = file.problem;
        std::uint64_t n = 0;
        if (problem.empty())
          {
            std::memcpy(&n, file.content.data(), sizeof(n));
            checksums.resize(n);
            std::memcpy(checksums.data(),
                        file.content.data() + sizeof(n),
                        n * sizeof(n));
            checkpoint.head = file.content.substr((n + 1) * sizeof(n));
          }
      }
    problem = agree_on_problem(communicator, problem);
    if (!problem.empty())
      return problem;
    checksums       = broadcast(communicator, checksums);
    checkpoint.head = broadcast(communicator, checkpoint.head);
    for (std::size_t r = this_mpi_process(communicator); r < checksums.size();
         r += n_mpi_processes(communicator))
      {
        SealedFile file = read_sealed_file(in(part_name(r)), format);
        if (problem.empty())
          problem = file.problem;
        if (problem.empty() && file.checksum != checksums[r])
          problem = "the file <" + in(part_name(r)) +
                    "> is of another checkpoint than its head";
        checkpoint.parts.push_back(std::move(file.content));
      }
    return agree_on_problem(communicator, problem);
  }

  void
  CheckpointFolder::set_aside_after(const unsigned int step) const
  {
    if (!is_first)
      return;
    for (const unsigned int other : steps())
      if (other > step)
        {
          const fs::path    path = path_of(other);
          const std::string name = "damaged-" + path.filename().string();
          std::error_code   ignored;
          fs::remove_all(path.parent_path() / name, ignored);
          fs::rename(path, path.parent_path() / name, ignored);
        }
  }
} // namespace emmy
