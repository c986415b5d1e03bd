#ifndef emmy_output_force_picture_h
#define emmy_output_force_picture_h

#include <iosfwd>
#include <string>
#include <vector>

namespace emmy
{
  /**
   * The gnuplot script that shows the force on a rigid tool against how far it
   * is from where it began; against time, if it rests. Used by Pictures.
   */
  struct ForcePicture
  {
    std::string  name; ///< of script and picture, "forces_plate"
    std::string  tool; ///< how its columns of the ledger begin, "tool_plate_"
    unsigned int dim = 2; ///< of the scene

    /** Write the complete script. @param title printed above, plain text */
    void
    write_script(std::ostream &script, const std::string &title) const;
  };

  /** One for each tool that has columns in a ledger. */
  std::vector<ForcePicture>
  force_pictures(const std::vector<std::string> &columns);
} // namespace emmy

#endif
