#ifndef emmy_base_sealed_file_h
#define emmy_base_sealed_file_h

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace emmy
{
  /**
   * A file that says whether it is whole: a mark, the number of its format, the
   * order of bytes, how long it is, the content, and a checksum of all that
   * (CRC-64, which sees each change of up to 64 bits in a row, and misses one
   * of 2^64 others). Content is kept bit by bit.
   */
  struct SealedFile
  {
    std::string   content;      ///< without the seal
    std::uint64_t checksum = 0; ///< of the file
    /** Why the content may not be used; empty: it is whole. */
    std::string problem;
  };

  /**
   * Write a sealed file, and hand it to the disk (fsync) before this returns.
   * What cannot be written is removed. For one rank. Throws nothing.
   *
   * @param format   what reader and writer must agree on
   * @param parts    of the content, one behind the other
   * @param checksum receives that of the file
   * @return what went wrong, with the file's name; empty if nothing did
   */
  std::string
  write_sealed_file(const std::string                   &filename,
                    const std::uint32_t                  format,
                    const std::vector<std::string_view> &parts,
                    std::uint64_t                       &checksum);

  /** Read one; of any other file or format .problem says what is wrong. */
  SealedFile
  read_sealed_file(const std::string &filename, const std::uint32_t format);

  /**
   * Hand the names in a folder, or the content of a file, to the disk: what
   * was renamed or written there survives a crash of the machine.
   * @return what went wrong; empty if nothing did
   */
  std::string
  flush_to_disk(const std::string &path);
} // namespace emmy

#endif
