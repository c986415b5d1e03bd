#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/study/study_list_parameters.h>
#include <emmy/study/study_parameters.h>

#include <algorithm>
#include <filesystem>
#include <memory>

namespace emmy
{
  using dealii::Patterns::Double;
  using dealii::Patterns::Integer;
  using dealii::Patterns::List;
  using dealii::Patterns::Selection;

  namespace
  {
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
        std::string              title, purpose, base_scene, directory;
        std::vector<std::string> names;
        std::string              combination = "crossed";
        std::vector<std::string> quantities;
        std::vector<std::string> references = {"last"};
        std::vector<double>      scales;
        std::string              refined_list, baseline;
        std::vector<double>      tolerances  = {1e-1, 1e-2, 1e-3, 1e-4};
        unsigned int             repetitions = 1;
        bool                     with_frames = false;

        General();
      };

    public:
      General                                           general;
      std::vector<std::unique_ptr<StudyListParameters>> lists;

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

      /** Position of a member that @p entry names. */
      unsigned int
      member(const std::string              &entry,
             const std::string              &name,
             const std::vector<StudyMember> &members) const;

      std::vector<StudyReference>
      references(const StudyPlan &plan) const;

      std::vector<double>
      scales(const StudyPlan &plan) const;

      unsigned int
      refined_list(const std::vector<StudyList> &lists) const;
    };

    StudyParameters::General::General()
      : Section("Study")
    {
      add_parameter("Title",
                    title,
                    "Of the page. Empty: the name of the file.");
      add_parameter("Purpose",
                    purpose,
                    "What the study asks, in a sentence or two, for the "
                    "page.");
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
                    "What is compared, from ledger.csv. COLUMN: its last "
                    "value. largest COLUMN: the largest in size. time of "
                    "largest COLUMN. path of COLUMN (or of NAME, for NAME_x, "
                    "NAME_y, NAME_z): all values. Each may end with from T, "
                    "to T (s).");
      add_parameter("Reference",
                    references,
                    "What is subtracted from a quantity to have its error: "
                    "one for all, or one for each. last: the last member, the "
                    "finest if values go from coarse to fine. member-NNN: "
                    "that one. limit: the one that the three finest members "
                    "of the last curve tend to (Richardson). A number: the "
                    "exact value. none: nothing, it is an error already.");
      add_parameter("Scales",
                    scales,
                    "What errors are divided by: one for all, or one for "
                    "each quantity. 0, and where nothing is given: the size "
                    "of the reference (of a path its range), or 1 if there "
                    "is none. Unit: that of the quantity.",
                    prm,
                    List(Double(0.)));
      add_parameter("Refined list",
                    refined_list,
                    "The list whose sizes are an axis, and whose orders are "
                    "fitted. Empty: the last one whose values are numbers.");
      add_parameter("Baseline",
                    baseline,
                    "A member that the page compares with: how many times "
                    "cheaper others have its error.");
      add_parameter("Tolerances",
                    tolerances,
                    "Errors for which the page names the cheapest setting.",
                    prm,
                    List(Double(0.)));
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
          lists.push_back(
            std::make_unique<StudyListParameters>("Study/" + name));
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
      plan.title       = general.title.empty()
                           ? std::filesystem::path(filename).stem().string()
                           : general.title;
      plan.purpose     = general.purpose;
      plan.file        = filename;
      plan.directory   = general.directory;
      plan.is_paired   = general.combination == "paired";
      plan.repetitions = general.repetitions;
      plan.with_frames = general.with_frames;
      plan.tolerances  = general.tolerances;
      std::sort(plan.tolerances.rbegin(), plan.tolerances.rend());
      for (unsigned int i = 0; i < lists.size(); ++i)
        plan.lists.push_back(lists[i]->list(general.names[i]));
      plan.members      = members(plan.lists);
      plan.quantities   = quantities();
      plan.refined_list = refined_list(plan.lists);
      plan.references   = references(plan);
      plan.scales       = scales(plan);
      if (!general.baseline.empty())
        plan.baseline = member("Baseline", general.baseline, plan.members);

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
      std::vector<StudyQuantity> result;
      for (const std::string &words : general.quantities)
        {
          StudyQuantity quantity;
          require(StudyQuantity::parse(words, quantity),
                  "Quantities",
                  words,
                  "write COLUMN, largest COLUMN, time of largest COLUMN or "
                  "path of COLUMN, with a column of the ledger; and from T, "
                  "to T behind it for a part of the run.");
          result.push_back(quantity);
        }
      return result;
    }

    unsigned int
    StudyParameters::member(const std::string              &entry,
                            const std::string              &name,
                            const std::vector<StudyMember> &members) const
    {
      const auto named = std::find_if(members.begin(),
                                      members.end(),
                                      [&name](const StudyMember &member) {
                                        return member.name == name;
                                      });
      require(named != members.end(),
              entry,
              name,
              (entry == "Reference" ? "use last, none, limit, a number, or "
                                    : "use ") +
                std::string("one of ") + members.front().name + " to " +
                members.back().name + ".");
      return named - members.begin();
    }

    std::vector<StudyReference>
    StudyParameters::references(const StudyPlan &plan) const
    {
      const auto one = [&](const std::string &word) {
        using Kind = StudyReference::Kind;
        StudyReference result;
        char          *end = nullptr;
        result.number      = std::strtod(word.c_str(), &end);
        if (word == "none")
          return result;
        if (word == "limit")
          {
            require(plan.has_sizes(),
                    "Reference",
                    word,
                    "a limit needs a list whose values, or Sizes, are "
                    "numbers.");
            result.kind = Kind::limit;
          }
        else if (!word.empty() && *end == '\0')
          result.kind = Kind::number;
        else
          {
            result.kind   = Kind::member;
            result.member = word == "last"
                              ? plan.members.size() - 1
                              : member("Reference", word, plan.members);
          }
        return result;
      };
      const auto &words = general.references;
      require(words.size() == 1 || words.size() == plan.quantities.size(),
              "Reference",
              join(words),
              "give one for all quantities, or one for each of them.");
      std::vector<StudyReference> result;
      for (unsigned int q = 0; q < plan.quantities.size(); ++q)
        {
          result.push_back(one(words[words.size() == 1 ? 0 : q]));
          require(plan.quantities[q].kind != StudyQuantity::Kind::path ||
                    result.back().kind == StudyReference::Kind::member,
                  "Reference",
                  join(words),
                  "<" + plan.quantities[q].words +
                    "> is compared with that of a member: use last or one "
                    "of member-NNN for it.");
        }
      return result;
    }

    std::vector<double>
    StudyParameters::scales(const StudyPlan &plan) const
    {
      const auto &given = general.scales;
      require(given.size() <= 1 || given.size() == plan.quantities.size(),
              "Scales",
              join_numbers(given),
              "give one for all quantities, or one for each of them.");
      if (given.size() == plan.quantities.size())
        return given;
      return std::vector<double>(plan.quantities.size(),
                                 given.empty() ? 0. : given[0]);
    }

    unsigned int
    StudyParameters::refined_list(const std::vector<StudyList> &lists) const
    {
      const std::string &name   = general.refined_list;
      unsigned int       result = lists.size();
      for (unsigned int i = 0; i < lists.size(); ++i)
        if (name.empty() ? lists[i].sizes.size() > 1 : lists[i].name == name)
          result = i;
      require(name.empty() ||
                (result < lists.size() && !lists[result].sizes.empty()),
              "Refined list",
              name,
              "name one of the lists, with values or Sizes that are numbers.");
      return result;
    }
  } // namespace

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
