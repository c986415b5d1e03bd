#include <emmy/base/text.h>
#include <emmy/run/scene_parameters.h>

#include <sstream>

namespace emmy
{
  ParameterFile
  reference_file()
  {
    std::ostringstream       text;
    std::vector<std::string> names;
    text << "set Dimension = 3\nsubsection Boundary conditions\n"
            "set Held parts = the part\nsubsection the part\nend\nend\n"
            "subsection Materials\n";
    for (const std::string &model : material_library<3>().names())
      {
        names.push_back("the " + model + " material");
        text << "subsection " << names.back() << "\nset Model = " << model
             << "\nend\n";
      }
    text << "set Names = " << join(names) << "\nend\nsubsection Bodies\n";
    names.clear();
    for (const std::string &shape : shape_library<3>().names())
      {
        names.push_back("the " + shape);
        text << "subsection " << names.back() << "\nset Shape = " << shape
             << "\nend\n";
      }
    text << "set Names = " << join(names) << "\nend\nsubsection Measurements\n";
    names.clear();
    for (const std::string &type : measurement_library<3>().names())
      {
        names.push_back("the " + type);
        text << "subsection " << names.back() << "\nset Type = " << type
             << "\nend\n";
      }
    text << "set Names = " << join(names) << "\nend\nsubsection Effects\n";
    for (const auto &entry : effect_library<3>().list())
      if (const auto effect = entry.make(effect_section(entry.name));
          !effect->one_of_each().empty())
        text << "subsection " << effect->path().substr(sizeof("Effects"))
             << '\n'
             << effect->one_of_each() << "end\n";
    text << "end\n";
    return ParameterFile::from_text(text.str(), "reference");
  }
} // namespace emmy
