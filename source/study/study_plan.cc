#include <emmy/base/text.h>
#include <emmy/study/study_plan.h>

namespace emmy
{
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
      for (const std::string &entry : lists[i].entries)
        if (!lists[i].is_ranks())
          result.set(entry + "=" + member.values[i], member.name);
    result.set("Output/Directory=" + folder(member, repetition), member.name);
    return result;
  }

  std::string
  StudyPlan::setting(const StudyMember &member) const
  {
    std::vector<std::string> items;
    for (unsigned int i = 0; i < lists.size(); ++i)
      items.push_back(lists[i].name + " = " + member.values[i]);
    return join(items);
  }

  unsigned int
  StudyPlan::ranks(const StudyMember &member) const
  {
    for (unsigned int i = 0; i < lists.size(); ++i)
      if (lists[i].is_ranks())
        return std::stoul(member.values[i]);
    return 0;
  }
} // namespace emmy
