#include <emmy/base/sealed_file.h>
#include <emmy/base/whole_file.h>

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace emmy
{
  namespace
  {
    /**
     * CRC-64 of ECMA-182, reflected, as xz has it; eight bytes at a time with
     * eight tables (Kounavis and Berry 2008), which is four times as fast as
     * boost::crc_optimal, and about as fast as a disk.
     */
    class Crc
    {
    public:
      void
      process_bytes(const void *data, std::size_t n)
      {
        static const Tables tables;
        const auto         &t    = tables.of_byte;
        const auto         *next = static_cast<const unsigned char *>(data);
        for (; n >= 8; n -= 8, next += 8)
          {
            std::uint64_t word = 0; // the first byte is the lowest
            for (unsigned int i = 0; i < 8; ++i)
              word |= std::uint64_t(next[i]) << (8 * i);
            word ^= remainder;
            remainder = 0;
            for (unsigned int i = 0; i < 8; ++i)
              remainder ^= t[7 - i][(word >> (8 * i)) & 255];
          }
        for (; n > 0; --n, ++next)
          remainder = (remainder >> 8) ^ t[0][(remainder ^ *next) & 255];
      }

      std::uint64_t
      checksum() const
      {
        return ~remainder;
      }

    private:
      /** [i][b]: the remainder of a byte b with i bytes behind it. */
      struct Tables
      {
        std::array<std::array<std::uint64_t, 256>, 8> of_byte;

        Tables()
        {
          for (unsigned int byte = 0; byte < 256; ++byte)
            {
              std::uint64_t r = byte;
              for (unsigned int bit = 0; bit < 8; ++bit)
                r = (r >> 1) ^ ((r & 1) ? 0xC96C5795D7870F42u : 0u);
              of_byte[0][byte] = r;
            }
          for (unsigned int i = 1; i < 8; ++i)
            for (unsigned int byte = 0; byte < 256; ++byte)
              of_byte[i][byte] = (of_byte[i - 1][byte] >> 8) ^
                                 of_byte[0][of_byte[i - 1][byte] & 255];
        }
      };

      std::uint64_t remainder = ~std::uint64_t(0);
    };

    /** Before the content. No padding: it is written as it stands. */
    struct Head
    {
      char          mark[16]  = {'e',
                                 'm',
                                 'm',
                                 'y',
                                 ' ',
                                 's',
                                 'e',
                                 'a',
                                 'l',
                                 'e',
                                 'd',
                                 ' ',
                                 'f',
                                 'i',
                                 'l',
                                 '\n'};
      std::uint32_t format    = 0;
      std::uint32_t byte_mark = 0x01020304; ///< order of bytes
      std::uint64_t length    = 0;          ///< of the content
    };
    static_assert(sizeof(Head) == 32);

    bool
    write_all(const int file, std::string_view text)
    {
      while (!text.empty())
        {
          const ssize_t n = ::write(file, text.data(), text.size());
          if (n < 0 && errno == EINTR)
            continue;
          if (n < 0)
            return false;
          text.remove_prefix(n);
        }
      return true;
    }

    template <class Number>
    std::string_view
    bytes_of(const Number &number)
    {
      return {reinterpret_cast<const char *>(&number), sizeof(number)};
    }
  } // namespace

  std::string
  write_sealed_file(const std::string                   &filename,
                    const std::uint32_t                  format,
                    const std::vector<std::string_view> &parts,
                    std::uint64_t                       &checksum)
  {
    Head head;
    head.format = format;
    for (const std::string_view part : parts)
      head.length += part.size();

    errno = 0;
    const int file =
      ::open(filename.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0)
      return cannot_write(filename, errno);
    Crc        crc;
    const auto put = [&](const std::string_view text) {
      crc.process_bytes(text.data(), text.size());
      return write_all(file, text);
    };
    bool is_written = put(bytes_of(head));
    for (const std::string_view part : parts)
      is_written = is_written && put(part);
    checksum         = crc.checksum();
    is_written       = is_written && write_all(file, bytes_of(checksum));
    is_written       = is_written && ::fsync(file) == 0;
    int error_number = is_written ? 0 : errno;
    if (::close(file) != 0 && is_written)
      {
        is_written   = false;
        error_number = errno;
      }
    if (is_written)
      return {};
    ::unlink(filename.c_str());
    return cannot_write(filename, error_number);
  }

  SealedFile
  read_sealed_file(const std::string &filename, const std::uint32_t format)
  {
    SealedFile result;
    const auto refuse = [&](const std::string &why) {
      result.content.clear();
      result.problem = "the file <" + filename + "> " + why;
      return result;
    };
    std::error_code error;
    const auto      size = std::filesystem::file_size(filename, error);
    if (error)
      return refuse("cannot be read (" + error.message() + ")");
    if (size < sizeof(Head) + sizeof(result.checksum))
      return refuse("is cut short");
    errno = 0;
    std::ifstream file(filename, std::ios::binary);
    Head          head;
    const Head    wanted;
    const auto    get = [&file](void *to, const std::size_t n) {
      return static_cast<bool>(file.read(static_cast<char *>(to), n));
    };
    if (!get(&head, sizeof(head)))
      return refuse("cannot be read" +
                    (errno ? std::string(" (") + std::strerror(errno) + ")"
                           : std::string()));
    if (std::memcmp(head.mark, wanted.mark, sizeof(head.mark)) != 0)
      return refuse("is damaged, or none of emmy's");
    if (head.byte_mark != wanted.byte_mark)
      return refuse("is damaged, or of a computer with another order of bytes");
    if (head.length != size - sizeof(Head) - sizeof(result.checksum))
      return refuse("is cut short or damaged");
    result.content.resize(head.length);
    std::uint64_t stored = 0;
    if (!get(result.content.data(), head.length) ||
        !get(&stored, sizeof(stored)))
      return refuse("cannot be read to its end");
    Crc crc;
    crc.process_bytes(&head, sizeof(head));
    crc.process_bytes(result.content.data(), result.content.size());
    result.checksum = crc.checksum();
    if (result.checksum != stored)
      return refuse("is damaged: its checksum is wrong");
    if (head.format != format)
      return refuse("has format " + std::to_string(head.format) +
                    ", and this emmy reads format " + std::to_string(format));
    return result;
  }

  std::string
  flush_to_disk(const std::string &path)
  {
    errno          = 0;
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0)
      return cannot_write(path, errno);
    // some file systems know no fsync of folders
    const bool is_done      = ::fsync(file) == 0 || errno == EINVAL;
    const int  error_number = errno;
    ::close(file);
    return is_done ? std::string() : cannot_write(path, error_number);
  }
} // namespace emmy
