#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/section.h>
#include <emmy/base/text.h>
#include <emmy/study/study_plan.h>

#include <algorithm>
#include <filesystem>
#include <memory>

namespace emmy
{
  using dealii::Patterns::Integer;
  using dealii::Patterns::Selection;

  namespace
  {
    /** Items between bars; blank ones too, as an empty value is a value. */
    std::vector<std::string>
    split_at_bars(const std::string &text)
    {
      // split_string_list() drops an empty last item
      auto items = dealii::Utilities::split_string_list(text + "|.", '|');
      items.pop_back();
      return items;
    }

    /** Section `Study/NAME`. */
    class ListParameters : public Section
    {
    public:
      std::string entries, values;

      explicit ListParameters(const std::string &path)
        : Section(path)
      {
        add_parameter("Entries",
                      entries,
                      "The entry of the base scene that the list varies, e.g. "
                      "Time/Step size. Several, with | between them, all take "
                      "the same value. Required.");
        add_parameter("Values",
                      values,
                      "The values, with | between them, from coarse to fine. "
                      "One may be empty. Required.");
      }

      StudyList
      list(const std::string &name) const
      {
        const auto require = [this](const bool         condition,
                                    const std::string &entry,
                                    const std::string &value,
                                    const std::string &advice) {
          AssertThrow(condition, ExcParameter(path(), entry, value, advice));
        };
        const StudyList result{name,
                               split_at_bars(entries),
                               split_at_bars(values)};
        for (const std::string &entry : result.entries)
          {
            require(!entry.empty(),
                    "Entries",
                    entries,
                    "name an entry of the base scene, e.g. Time/Step size.");
            require(entry != "Output/Directory" && entry != "Output/Overwrite",
                    "Entries",
                    entries,
                    "the study chooses each member's folder. Vary another "
                    "entry.");
          }
        require(!values.empty(),
                "Values",
                values,
                "it is required. Separate values by |, e.g. 0.1 | 0.05.");
        for (const std::string &value : result.values)
          require(std::count(result.values.begin(),
                             result.values.end(),
                             value) == 1,
                  "Values",
                  values,
                  "<" + value + "> is there twice. Remove one of them.");
        return result;
      }
    };

    /** Section `Study`. Exists only while it is read. */
    class StudyParameters
    {
    private:
      /** Empties ParameterAcceptor's list of what was there before. */
      struct Cleared
      {
        Cleared()
        {
          dealii::ParameterAcceptor::clear();
        }
      } cleared;

      /** The entries of the section itself. */
      class General : public Section
      {
      public:
        std::string              base_scene, directory;
        std::vector<std::string> names;
        std::string              combination = "crossed";
        std::vector<std::string> quantities;
        std::string              reference   = "last";
        unsigned int             repetitions = 1;
        bool                     with_frames = false;

        General();
      };

    public:
      General                                      general;
      std::vector<std::unique_ptr<ListParameters>> lists;

      explicit StudyParameters(const ParameterFile &file);

      StudyPlan
      plan(const std::string &filename) const;

    private:
      /** Throws ExcParameter for an entry of the section itself. */
      void
      require(const bool         condition,
              const std::string &entry,
              const std::string &value,
              const std::string &advice) const
      {
        AssertThrow(condition,
                    ExcParameter(general.path(), entry, value, advice));
      }

      std::vector<StudyMember>
      members(const std::vector<StudyList> &lists) const;

      std::vector<StudyQuantity>
      quantities() const;

      unsigned int
      reference(const std::vector<StudyMember> &members) const;
    };

    StudyParameters::General::General()
      : Section("Study")
    {
      add_parameter("Base scene",
                    base_scene,
                    "The parameter file that the members vary; relative to "
                    "the file of the study. Required.");
      add_parameter("Directory",
                    directory,
                    "Where study.csv and the folders of the members go; "
                    "relative to the current folder, as Output/Directory is. "
                    "Required.");
      add_parameter("Names",
                    names,
                    "Names of the lists. Each has a section of its name and "
                    "a column in study.csv. Required.");
      add_parameter("Combination",
                    combination,
                    "crossed: every value with every other; the last list "
                    "varies fastest. paired: the first values of all lists, "
                    "then the second, ...; a list of one value keeps it.",
                    prm,
                    Selection("crossed|paired"));
      add_parameter("Quantities",
                    quantities,
                    "What is compared: columns of ledger.csv. NAME: at the "
                    "end of the run. largest NAME: the largest in size over "
                    "the run.");
      add_parameter("Reference",
                    reference,
                    "What is subtracted from quantities. last: the last "
                    "member, the finest if values go from coarse to fine. "
                    "member-NNN: that one. none: nothing.");
      add_parameter("Repetitions",
                    repetitions,
                    "How often each member runs, for the spread of its "
                    "seconds.",
                    prm,
                    Integer(1, 1000));
      add_parameter("Frames and pictures",
                    with_frames,
                    "Whether members write the frames and pictures of the "
                    "base scene, which take time.");
    }

    StudyParameters::StudyParameters(const ParameterFile &file)
    {
      for (const std::string &name :
           dealii::Utilities::split_string_list(file.value("Study/Names", "")))
        {
          require(!name.empty() && name.find('/') == std::string::npos,
                  "Names",
                  name,
                  "names must not be empty and hold no slash.");
          lists.push_back(std::make_unique<ListParameters>("Study/" + name));
        }
      file.parse(dealii::ParameterAcceptor::prm);
      dealii::ParameterAcceptor::parse_all_parameters();
    }

    StudyPlan
    StudyParameters::plan(const std::string &filename) const
    {
      require(!general.base_scene.empty(),
              "Base scene",
              "",
              "it is required: the parameter file that is varied.");
      require(!general.directory.empty(),
              "Directory",
              "",
              "it is required, e.g. results/studies/my-study.");
      require(!lists.empty(),
              "Names",
              "",
              "it is required: the lists of values, each with a section of "
              "its name.");
      StudyPlan plan;
      plan.directory   = general.directory;
      plan.repetitions = general.repetitions;
      plan.with_frames = general.with_frames;
      for (unsigned int i = 0; i < lists.size(); ++i)
        plan.lists.push_back(lists[i]->list(general.names[i]));
      plan.members    = members(plan.lists);
      plan.quantities = quantities();
      plan.reference  = reference(plan.members);

      const auto scene =
        (std::filesystem::path(filename).parent_path() / general.base_scene)
          .lexically_normal();
      require(std::filesystem::is_regular_file(scene),
              "Base scene",
              general.base_scene,
              "there is no file <" + scene.string() +
                ">. Give a path relative to the file of the study.");
      plan.base_scene = ParameterFile(scene.string());
      return plan;
    }

    std::vector<StudyMember>
    StudyParameters::members(const std::vector<StudyList> &lists) const
    {
      const bool   is_crossed = general.combination == "crossed";
      unsigned int n_members  = 1;
      for (const StudyList &list : lists)
        {
          const unsigned int n_values = list.values.size();
          if (is_crossed)
            n_members *= n_values;
          else if (n_values > 1)
            {
              require(n_members == 1 || n_values == n_members,
                      "Combination",
                      general.combination,
                      "list <" + list.name + "> has " +
                        std::to_string(n_values) +
                        " values, another one before it " +
                        std::to_string(n_members) +
                        ". Give as many (or one), or set Combination = "
                        "crossed.");
              n_members = n_values;
            }
        }
      std::vector<StudyMember> result(n_members);
      for (unsigned int m = 0; m < n_members; ++m)
        {
          result[m].name =
            "member-" +
            dealii::Utilities::int_to_string(
              m + 1,
              std::max(3u, dealii::Utilities::needed_digits(n_members + 1)));
          unsigned int block = n_members; // members that share the value
          for (const StudyList &list : lists)
            {
              block /= is_crossed ? list.values.size() : block;
              result[m].values.push_back(
                list.values[m / block % list.values.size()]);
            }
        }
      return result;
    }

    std::vector<StudyQuantity>
    StudyParameters::quantities() const
    {
      const std::string          largest = "largest ";
      std::vector<StudyQuantity> result;
      for (const std::string &words : general.quantities)
        {
          const bool is_largest = words.substr(0, largest.size()) == largest;
          const std::string column =
            is_largest ? dealii::Utilities::trim(words.substr(largest.size()))
                       : words;
          require(!column.empty() && column.find(' ') == std::string::npos,
                  "Quantities",
                  words,
                  "write the name of a column of the ledger, or <largest "
                  "NAME>.");
          result.push_back({column, is_largest});
        }
      return result;
    }

    unsigned int
    StudyParameters::reference(const std::vector<StudyMember> &members) const
    {
      if (general.reference == "none")
        return StudyPlan::no_reference;
      if (general.reference == "last")
        return members.size() - 1;
      const auto named = std::find_if(members.begin(),
                                      members.end(),
                                      [this](const StudyMember &member) {
                                        return member.name == general.reference;
                                      });
      require(named != members.end(),
              "Reference",
              general.reference,
              "use last, none, or one of " + members.front().name + " to " +
                members.back().name + ".");
      return named - members.begin();
    }
  } // namespace

  std::string
  StudyQuantity::name() const
  {
    return (is_largest ? "largest_" : "") + column;
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
      for (const std::string &entry : lists[i].entries)
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

  StudyPlan
  read_study(const ParameterFile &file, const std::string &filename)
  {
    AssertThrow(file.has_section("Study"),
                ExcRun("Study",
                       "<" + filename + "> has no section Study",
                       "run a scene with emmy FILE.prm; doc/study.md shows "
                       "how to write a study of it."));
    return StudyParameters(file).plan(filename);
  }

  void
  print_study_parameters(const ParameterFile &file, std::ostream &out)
  {
    const StudyParameters parameters(file);
    dealii::ParameterAcceptor::prm.print_parameters(
      out,
      dealii::ParameterHandler::PRM |
        dealii::ParameterHandler::KeepDeclarationOrder);
  }

  ParameterFile
  reference_study()
  {
    return ParameterFile::from_text(
      "subsection Study\nset Names = the list\nend\n", "reference");
  }
} // namespace emmy
