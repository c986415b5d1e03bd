#include <emmy/base/whole_file.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace emmy
{
  const std::string file_remedy =
    "check that its folder exists, that you may write there, and that the disk "
    "is not full.";

  std::string
  cannot_write(const std::string &filename, const int error_number)
  {
    return "the file <" + filename + "> cannot be written" +
           (error_number == 0
              ? std::string()
              : std::string(" (") + std::strerror(error_number) + ")");
  }

  std::string
  write_whole_file(const std::string &filename, const std::string &content)
  {
    namespace fs            = std::filesystem;
    const std::string aside = filename + ".new";
    errno                   = 0;
    std::ofstream out(aside, std::ios::binary);
    const bool    is_open = out.is_open();
    out.write(content.data(), content.size());
    out.close(); // fails too if something before it did
    const int       error_number = errno;
    std::error_code error;
    if (out)
      fs::rename(aside, filename, error);
    if (out && !error)
      return {};
    std::error_code ignored;
    if (is_open)
      fs::remove(aside, ignored);
    return cannot_write(filename, error ? error.value() : error_number);
  }
} // namespace emmy
