#include <deal.II/base/utilities.h>

#include <emmy/particles/particle_columns.h>

#include <boost/algorithm/string/predicate.hpp>
#include <boost/iostreams/copy.hpp>
#include <boost/iostreams/device/array.hpp>
#include <boost/iostreams/filter/zlib.hpp>
#include <boost/iostreams/filtering_stream.hpp>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <stdexcept>

namespace emmy
{
  namespace
  {
    using boost::property_tree::ptree;
    using Bytes = std::vector<unsigned char>;

    [[noreturn]] void
    refuse(const std::string &what)
    {
      throw std::runtime_error(what); // read_vtu_columns() catches it
    }

    /** Numbers of type @p T that lie in bytes. */
    template <class T>
    std::vector<double>
    as(const Bytes &bytes)
    {
      std::vector<double> result(bytes.size() / sizeof(T));
      for (std::size_t i = 0; i < result.size(); ++i)
        {
          T number;
          std::memcpy(&number, bytes.data() + i * sizeof(T), sizeof(T));
          result[i] = number;
        }
      return result;
    }

    std::vector<double>
    numbers_of(const std::string &type, const Bytes &bytes)
    {
      if (type == "Float32")
        return as<float>(bytes);
      if (type == "Float64")
        return as<double>(bytes);
      if (type == "Int8" || type == "UInt8")
        return type == "Int8" ? as<std::int8_t>(bytes)
                              : as<std::uint8_t>(bytes);
      if (type == "Int32" || type == "UInt32")
        return type == "Int32" ? as<std::int32_t>(bytes)
                               : as<std::uint32_t>(bytes);
      if (type == "Int64" || type == "UInt64")
        return type == "Int64" ? as<std::int64_t>(bytes)
                               : as<std::uint64_t>(bytes);
      refuse("its numbers are of the type " + type);
    }

    /** How arrays are coded in a file. */
    struct Coding
    {
      bool        is_compressed = false;
      std::string counts; ///< type of the numbers before the data
    };

    Bytes
    inflated(const Bytes &bytes, const std::size_t first, const std::size_t n)
    {
      namespace io = boost::iostreams;
      io::filtering_istream stream;
      stream.push(io::zlib_decompressor());
      stream.push(
        io::array_source(reinterpret_cast<const char *>(bytes.data()) + first,
                         n));
      std::ostringstream out;
      io::copy(stream, out);
      const std::string text = out.str();
      return Bytes(text.begin(), text.end());
    }

    /** How many letters of base64 so many bytes are. */
    std::size_t
    coded_size(const std::size_t n)
    {
      return 4 * ((n + 2) / 3);
    }

    /** What is coded in base64, after the counts before it. */
    Bytes
    decoded(const std::string &text, const Coding &coding)
    {
      using dealii::Utilities::decode_base64;
      const std::size_t size = coding.counts == "UInt64" ? 8 : 4;
      if (!coding.is_compressed)
        {
          Bytes bytes = decode_base64(text);
          bytes.erase(bytes.begin(),
                      bytes.begin() + std::min(size, bytes.size()));
          return bytes;
        }
      // the number of blocks, two sizes, and the coded size of each block
      const auto count = [&](const std::size_t n) {
        return numbers_of(coding.counts,
                          decode_base64(text.substr(0, coded_size(n * size))));
      };
      const std::size_t n_blocks = count(1).at(0);
      const auto        head     = count(3 + n_blocks);
      const Bytes       all =
        decode_base64(text.substr(coded_size((3 + n_blocks) * size)));
      Bytes       result;
      std::size_t first = 0;
      for (std::size_t block = 0; block < n_blocks; ++block)
        {
          const std::size_t n = head.at(3 + block);
          if (first + n > all.size())
            refuse("an array is cut short");
          const Bytes part = inflated(all, first, n);
          result.insert(result.end(), part.begin(), part.end());
          first += n;
        }
      return result;
    }

    std::vector<double>
    array_of(const ptree &array, const Coding &coding)
    {
      const std::string format = array.get("<xmlattr>.format", "");
      std::string       text   = dealii::Utilities::trim(array.data());
      if (format == "ascii")
        {
          std::istringstream  in(text);
          std::vector<double> result;
          for (double number; in >> number;)
            result.push_back(number);
          return result;
        }
      if (format != "binary")
        refuse("its arrays are <" + format +
               ">; write them as ascii or binary (in ParaView: Data Mode)");
      return numbers_of(array.get("<xmlattr>.type", ""), decoded(text, coding));
    }

    /** The endings of the columns of an array, and where they stand. */
    std::vector<std::pair<std::string, unsigned int>>
    endings(const unsigned int n_components)
    {
      if (n_components == 1)
        return {{"", 0}};
      if (n_components == 3)
        return {{"_x", 0}, {"_y", 1}, {"_z", 2}};
      if (n_components == 9)
        return {{"_xx", 0},
                {"_yy", 4},
                {"_zz", 8},
                {"_xy", 1},
                {"_xz", 2},
                {"_yz", 5}};
      if (n_components == 6) // symmetric tensors, as ParaView orders them
        return {{"_xx", 0},
                {"_yy", 1},
                {"_zz", 2},
                {"_xy", 3},
                {"_yz", 4},
                {"_xz", 5}};
      refuse("an array has " + std::to_string(n_components) + " components");
    }

    void
    append(const std::string &name,
           const ptree       &array,
           const Coding      &coding,
           ParticleColumns   &columns)
    {
      const unsigned int n = array.get("<xmlattr>.NumberOfComponents", 1u);
      const auto         numbers = array_of(array, coding);
      if (numbers.size() != n * columns.rows.size())
        refuse("its array <" + name + "> has " +
               std::to_string(numbers.size()) + " numbers, and there are " +
               std::to_string(columns.rows.size()) + " points");
      for (const auto &[ending, place] : endings(n))
        {
          columns.names.push_back(name.empty() ? std::string(1, ending[1])
                                               : name + ending);
          for (std::size_t p = 0; p < columns.rows.size(); ++p)
            {
              columns.rows[p].push_back(numbers[n * p + place]);
              if (!std::isfinite(columns.rows[p].back()))
                refuse("its array <" + name +
                       "> has numbers that are not "
                       "finite");
            }
        }
    }

    ParticleColumns
    read_piece(const ptree &piece, const Coding &coding)
    {
      ParticleColumns result;
      result.rows.resize(piece.get<std::size_t>("<xmlattr>.NumberOfPoints"));
      append("", piece.get_child("Points.DataArray"), coding, result);
      if (const auto data = piece.get_child_optional("PointData"))
        for (const auto &[tag, array] : *data)
          if (tag == "DataArray")
            append(array.get("<xmlattr>.Name", ""), array, coding, result);
      return result;
    }

    void
    join(ParticleColumns piece, ParticleColumns &all)
    {
      if (piece.rows.empty())
        return;
      if (!all.names.empty() && all.names != piece.names)
        refuse("its pieces have different arrays");
      all.names = std::move(piece.names);
      for (auto &row : piece.rows)
        all.rows.push_back(std::move(row));
    }

    ParticleColumns
    read_file(const std::string &file)
    {
      ptree tree;
      boost::property_tree::read_xml(file, tree);
      const ptree    &root = tree.get_child("VTKFile");
      ParticleColumns result;
      if (const auto list = root.get_child_optional("PUnstructuredGrid"))
        {
          const auto folder = std::filesystem::path(file).parent_path();
          for (const auto &[tag, piece] : *list)
            if (tag == "Piece")
              join(read_file(
                     (folder / piece.get<std::string>("<xmlattr>.Source"))
                       .string()),
                   result);
          return result;
        }
      const std::string compressor = root.get("<xmlattr>.compressor", "");
      if (!compressor.empty() && compressor != "vtkZLibDataCompressor")
        refuse("it is compressed by " + compressor + "; use zlib, or none");
      if (root.get("<xmlattr>.byte_order", "LittleEndian") != "LittleEndian")
        refuse("its bytes are in the order of other machines (BigEndian)");
      const Coding coding{!compressor.empty(),
                          root.get("<xmlattr>.header_type", "UInt32")};
      for (const auto &[tag, piece] : root.get_child("UnstructuredGrid"))
        if (tag == "Piece")
          join(read_piece(piece, coding), result);
      return result;
    }
  } // namespace

  ParticleColumns
  read_vtu_columns(const std::string &file)
  {
    try
      {
        return read_file(file);
      }
    catch (const std::exception &error) // of the parser, too
      {
        ParticleColumns nothing;
        nothing.problem =
          std::string("it cannot be read as a .vtu: ") + error.what();
        return nothing;
      }
  }
} // namespace emmy
