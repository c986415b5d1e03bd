#ifndef emmy_base_whole_file_h
#define emmy_base_whole_file_h

#include <string>

namespace emmy
{
  /**
   * Write a file whole or not at all: beside it, as FILENAME.new, then renamed.
   * Who reads it, and who comes after a run that was killed, meets the old
   * file or the new one, never half of one. A file that cannot be written
   * leaves no FILENAME.new. For one rank. Throws nothing.
   *
   * @return what went wrong, with the file's name; empty if nothing did
   */
  std::string
  write_whole_file(const std::string &filename, const std::string &content);

  /**
   * That @p filename cannot be written, and why if the system just said so
   * in @p error_number (errno; 0: it did not).
   */
  std::string
  cannot_write(const std::string &filename, const int error_number = 0);

  /** What to do about a file that cannot be written. */
  extern const std::string file_remedy;
} // namespace emmy

#endif
