#include <emmy/base/text.h>
#include <emmy/study/study_plan.h>

#include <algorithm>

namespace emmy
{
  unsigned int
  StudyList::position(const std::string &value) const
  {
    return std::find(values.begin(), values.end(), value) - values.begin();
  }

  std::string
  StudyPlan::folder(const StudyMember &member,
                    const unsigned int repetition) const
  {
    return directory + "/" + member.name +
           (repetition == 0 ? ""
                            : "/repetition-" + std::to_string(repetition + 1));
  }

  ParameterFile
  StudyPlan::scene(const StudyMember &member,
                   const unsigned int repetition) const
  {
    ParameterFile result = base_scene;
    if (!with_frames)
      for (const char *entry : {"Frames=0", "Pictures=false"})
        result.set(std::string("Output/") + entry, member.name);
    // after that: a list may ask for frames
    for (unsigned int i = 0; i < lists.size(); ++i)
      for (unsigned int e = 0; e < lists[i].entries.size(); ++e)
        if (!lists[i].is_ranks())
          result.set(
            lists[i].entries[e] + "=" +
              lists[i].settings[lists[i].position(member.values[i])][e],
            member.name);
    result.set("Output/Directory=" + folder(member, repetition), member.name);
    return result;
  }

  std::string
  StudyPlan::setting(const StudyMember &member) const
  {
    std::vector<std::string> items;
    for (unsigned int i = 0; i < lists.size(); ++i)
      if (lists[i].varies())
        items.push_back(lists[i].name + " = " + member.values[i]);
    return join(items);
  }

  unsigned int
  StudyPlan::ranks(const StudyMember &member) const
  {
    for (unsigned int i = 0; i < lists.size(); ++i)
      if (lists[i].is_ranks())
        return std::stoul(
          lists[i].settings[lists[i].position(member.values[i])][0]);
    return 0;
  }
} // namespace emmy
