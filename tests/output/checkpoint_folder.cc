// Checkpoints are whole, or not used: cut short, with any byte changed, of
// another format, mixed up, or on a disk that does not take them, all ranks
// read the one before, and what was written earlier stays.

#include <emmy/base/sealed_file.h>
#include <emmy/output/checkpoint_folder.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "../check.h"

using namespace emmy;
using emmy::test::check;
namespace fs = std::filesystem;

namespace
{
  const MPI_Comm all = MPI_COMM_WORLD;

  unsigned int
  rank()
  {
    return dealii::Utilities::MPI::this_mpi_process(all);
  }

  void
  wait_for_all()
  {
    MPI_Barrier(all);
  }

  std::string
  bytes_of(const fs::path &file)
  {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  void
  write_bytes(const fs::path &file, const std::string &bytes)
  {
    std::ofstream(file, std::ios::binary) << bytes;
  }

  /** What this rank writes at a step. */
  std::string
  part_at(const unsigned int step)
  {
    std::string text;
    for (unsigned int i = 0; i < 200; ++i)
      text += static_cast<char>((i * i + 31 * step + 7 * rank()) % 256);
    return text;
  }

  std::string
  head_at(const unsigned int step)
  {
    return "head of step " + std::to_string(step) + std::string(300, 'x');
  }

  std::string
  write(const CheckpointFolder &folder,
        const unsigned int      step,
        const unsigned int      n_kept = 5)
  {
    const std::string part = part_at(step);
    return folder.write(step,
                        head_at(step),
                        {std::string_view(part).substr(0, 50),
                         std::string_view(part).substr(50)},
                        n_kept);
  }

  /** Whether the newest is that of a step, to the last bit. */
  bool
  reads(const CheckpointFolder &folder, const unsigned int step)
  {
    const ReadCheckpoint found = folder.read_newest(1000000);
    const bool is_right = found.step == step && found.head == head_at(step) &&
                          found.parts.size() == 1 &&
                          found.parts[0] == part_at(step);
    return dealii::Utilities::MPI::min(is_right ? 1 : 0, all) == 1;
  }

  /** The files of the checkpoint of step 20. */
  std::vector<fs::path>
  files(const fs::path &directory)
  {
    std::vector<fs::path> result{directory / "checkpoints/step-00000020/head"};
    for (unsigned int r = 0; r < dealii::Utilities::MPI::n_mpi_processes(all);
         ++r)
      result.push_back(directory / "checkpoints/step-00000020" /
                       ("particles." + std::to_string(r)));
    return result;
  }

  void
  damaged_bytes(const fs::path &directory)
  {
    const CheckpointFolder folder(directory.string(), all);
    unsigned int           n_places = 0, n_lengths = 0;
    for (const fs::path &file : files(directory))
      {
        const std::string whole = bytes_of(file);
        wait_for_all();
        // the first bytes are the mark, the format, the length
        for (std::size_t place = 0; place < whole.size();
             place += place < 34 ? 1 : 1 + whole.size() / 200)
          for (const int change : {1, 128})
            {
              if (rank() == 0)
                {
                  std::string other = whole;
                  other[place] ^= change;
                  write_bytes(file, other);
                }
              wait_for_all();
              check(reads(folder, 10),
                    "byte " + std::to_string(place) + " of " + file.string());
              ++n_places;
              wait_for_all();
            }
        for (std::size_t length = 0; length < whole.size();
             length += 1 + whole.size() / 40)
          {
            if (rank() == 0)
              write_bytes(file, whole.substr(0, length));
            wait_for_all();
            check(reads(folder, 10),
                  std::to_string(length) + " bytes of " + file.string());
            ++n_lengths;
            wait_for_all();
          }
        if (rank() == 0)
          write_bytes(file, whole + "x");
        wait_for_all();
        check(reads(folder, 10), "one byte more of " + file.string());
        wait_for_all();
        if (rank() == 0)
          fs::remove(file);
        wait_for_all();
        check(reads(folder, 10), "no " + file.string());
        wait_for_all();
        if (rank() == 0)
          write_bytes(file, whole);
        wait_for_all();
        check(reads(folder, 20), "as it was: " + file.string());
        wait_for_all();
      }
    check(n_places >= 200, "at least 200 places were changed");
    check(n_lengths >= 40, "files were cut at many places");
  }

  void
  other_formats(const fs::path &directory)
  {
    const CheckpointFolder folder(directory.string(), all);
    for (const fs::path &file : files(directory))
      {
        const std::string whole = bytes_of(file);
        wait_for_all();
        if (rank() == 0)
          {
            const SealedFile content =
              read_sealed_file(file.string(), CheckpointFolder::format);
            std::uint64_t checksum = 0;
            write_sealed_file(file.string(),
                              CheckpointFolder::format + 1,
                              {content.content},
                              checksum);
          }
        wait_for_all();
        check(reads(folder, 10), "another format of " + file.string());
        const ReadCheckpoint found = folder.read_newest(1000);
        check(found.passed_over.size() == 1 &&
                found.passed_over[0].find(
                  "has format " + std::to_string(CheckpointFolder::format + 1) +
                  ", and this emmy reads format " +
                  std::to_string(CheckpointFolder::format)) !=
                  std::string::npos,
              "and it is said");
        wait_for_all();
        if (rank() == 0)
          write_bytes(file, whole);
        wait_for_all();
      }
    // whole, but of another step
    const fs::path    mixed = files(directory)[1];
    const std::string whole = bytes_of(mixed);
    wait_for_all();
    if (rank() == 0)
      fs::copy_file(directory / "checkpoints/step-00000010/particles.0",
                    mixed,
                    fs::copy_options::overwrite_existing);
    wait_for_all();
    check(reads(folder, 10), "particles of another step");
    wait_for_all();
    if (rank() == 0)
      write_bytes(mixed, whole);
    wait_for_all();
  }

  void
  what_is_kept(const fs::path &directory)
  {
    const CheckpointFolder folder(directory.string(), all);
    const auto             there = [&] {
      unsigned int n = 0;
      for (const auto &entry :
           fs::directory_iterator(directory / "checkpoints"))
        n += fs::is_directory(entry);
      wait_for_all();
      return n;
    };
    for (const unsigned int step : {30, 40, 50})
      check(write(folder, step, 2).empty(), "written");
    wait_for_all();
    check(there() == 2, "the last two are kept");
    check(reads(folder, 50), "and the last is read");
    wait_for_all();
    check(write(folder, 50, 2).empty() && reads(folder, 50) && there() == 2,
          "one that is there is replaced");
    check(folder.read_newest(49).step == 40, "one that is not newer");
    wait_for_all();
    folder.set_aside_after(40);
    wait_for_all();
    check(reads(folder, 40), "newer ones are set aside");
    wait_for_all();
  }

  void
  what_cannot_be_written(const fs::path &directory)
  {
    const CheckpointFolder folder(directory.string(), all);
    wait_for_all();
    // what a run left that was killed while it wrote
    if (rank() == 0)
      {
        const fs::path aside = directory / "checkpoints/step-00000060.new";
        fs::create_directories(aside);
        write_bytes(aside / "head", "half");
      }
    wait_for_all();
    check(reads(folder, 40), "half a checkpoint is none");
    check(write(folder, 60).empty() && reads(folder, 60),
          "and it is in no one's way");
    const fs::path nowhere = directory / "a file";
    if (rank() == 0)
      write_bytes(nowhere, "");
    wait_for_all();
    check(!write(CheckpointFolder(nowhere.string(), all), 60).empty(),
          "no folder can be made in a file");
    check(CheckpointFolder(nowhere.string(), all).read_newest(100).path.empty(),
          "and there is nothing to read");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const unsigned int n         = dealii::Utilities::MPI::n_mpi_processes(all);
  const fs::path     directory = "checkpoint_folder_" + std::to_string(n);
  if (rank() == 0)
    {
      fs::remove_all(directory);
      fs::create_directories(directory);
    }
  wait_for_all();
  const CheckpointFolder folder(directory.string(), all);
  check(write(folder, 10).empty() && write(folder, 20).empty(), "written");
  check(reads(folder, 20), "read");
  damaged_bytes(directory);
  other_formats(directory);
  what_is_kept(directory);
  what_cannot_be_written(directory);
  wait_for_all();
  if (rank() == 0)
    fs::remove_all(directory);
  return emmy::test::report();
}
