#include <emmy/effects/effect.h>

#include <cctype>

namespace emmy
{
  std::string
  effect_section(const std::string &effect_name)
  {
    std::string section = effect_name;
    if (!section.empty())
      section[0] = std::toupper(static_cast<unsigned char>(section[0]));
    return "Effects/" + section;
  }
} // namespace emmy
