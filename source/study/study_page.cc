#include <emmy/base/text.h>
#include <emmy/study/study_page.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>

namespace emmy
{
  namespace
  {
    /** Three digits; a dash if it is not known. */
    std::string
    number(const double value)
    {
      char text[32];
      std::snprintf(text, sizeof(text), "%.3g", value);
      return std::isnan(value) ? "-" : text;
    }

    /** An order, with two decimals. */
    std::string
    rounded(const double value)
    {
      char text[32];
      std::snprintf(text, sizeof(text), "%.2f", value);
      return text;
    }

    /** "x 1.23", for ratios. */
    std::string
    times(const double ratio)
    {
      return std::isnan(ratio) ? "-" : "x " + number(ratio);
    }

    /** Cells of a row of a table. A bar would end a cell. */
    void
    write_row(std::ostream &out, const std::vector<std::string> &cells)
    {
      out << '|';
      for (const std::string &cell : cells)
        out << ' ' << dealii::Utilities::replace_in_string(cell, "|", "\\|")
            << " |";
      out << '\n';
    }

    void
    write_head(std::ostream &out, const std::vector<std::string> &cells)
    {
      out << '\n';
      write_row(out, cells);
      out << '|';
      for (std::size_t i = 0; i < cells.size(); ++i)
        out << "---|";
      out << '\n';
    }

    /** What an error of a quantity is: of what, and over what. */
    std::string
    definition(const StudyPlan   &plan,
               const StudyTable  &table,
               const unsigned int q)
    {
      const StudyReference &reference = plan.references[q];
      using Kind                      = StudyReference::Kind;
      std::string text                = "- `" + plan.quantities[q].words + "`";
      if (reference.kind == Kind::none)
        text += ": its own size";
      else if (reference.kind == Kind::number)
        text += ": against the exact " + shortest(reference.number);
      else if (reference.kind == Kind::member)
        text += ": against " + plan.members[reference.member].name + " (" +
                plan.setting(plan.members[reference.member]) + ")" +
                (table.is_done(reference.member)
                   ? ""
                   : ", which is not done: no errors are known");
      else if (std::isnan(table.reference(q)))
        text += ": the finest members tend to no limit: no errors are known";
      else
        text += ": against the limit " + brief(table.reference(q)) +
                " of the finest three of the last curve that are done, "
                "approached with "
                "order " +
                number(table.limit_order(q));
      if (plan.scales[q] > 0.)
        text += ", over " + shortest(plan.scales[q]);
      else if (table.reference(q) == 0.)
        text += ", absolute, as that is zero";
      else if (plan.quantities[q].kind == StudyQuantity::Kind::path)
        text += ", root mean square over the range of that";
      else if (reference.kind != Kind::none)
        text += ", over its size";
      return text;
    }

    void
    write_cheapest(std::ostream     &out,
                   const StudyPlan  &plan,
                   const StudyTable &table)
    {
      out << "\n## The cheapest setting for a tolerance\n";
      write_head(out, {"error of", "at most", "setting", "seconds", "error"});
      for (unsigned int q = 0; q < plan.quantities.size(); ++q)
        for (const double tolerance : plan.tolerances)
          {
            const int m =
              cheapest(table.all_seconds(), table.errors(q), tolerance);
            write_row(out,
                      {plan.quantities[q].words,
                       shortest(tolerance),
                       m < 0 ? "none" : plan.setting(plan.members[m]),
                       m < 0 ? "-" : number(table.seconds(m)),
                       m < 0 ? "-" : number(table.error(m, q))});
          }
    }

    void
    write_baseline(std::ostream     &out,
                   const StudyPlan  &plan,
                   const StudyTable &table)
    {
      out << "\n## Against the baseline\n\n"
          << plan.members[plan.baseline].name << ": "
          << plan.setting(plan.members[plan.baseline]) << ". "
          << number(table.seconds(plan.baseline)) << " s.\n";
      write_head(out,
                 {"error of",
                  "of the baseline",
                  "cheapest with at most that",
                  "its error",
                  "seconds",
                  "times cheaper"});
      for (unsigned int q = 0; q < plan.quantities.size(); ++q)
        {
          const double error = table.error(plan.baseline, q);
          const int m = cheapest(table.all_seconds(), table.errors(q), error);
          write_row(out,
                    {plan.quantities[q].words,
                     number(error),
                     m < 0 ? "-" : plan.setting(plan.members[m]),
                     m < 0 ? "-" : number(table.error(m, q)),
                     m < 0 ? "-" : number(table.seconds(m)),
                     m < 0 ? "-"
                           : number(table.seconds(plan.baseline) /
                                    table.seconds(m))});
        }
    }

    void
    write_choices(std::ostream     &out,
                  const StudyPlan  &plan,
                  const StudyTable &table)
    {
      const auto choices = study_choices(plan, table);
      if (choices.empty())
        return;
      out << "\n## What each choice costs and brings\n\nGeometric means over "
             "all pairs of members that differ in nothing else; of errors over "
             "those that are known and not zero.\n";
      std::vector<std::string> head{"list", "from", "to", "seconds"};
      for (const StudyQuantity &quantity : plan.quantities)
        head.push_back("error of " + quantity.words);
      head.push_back("pairs");
      write_head(out, head);
      for (const StudyChoice &choice : choices)
        {
          const StudyList         &list = plan.lists[choice.list];
          std::vector<std::string> row{list.name,
                                       list.values[0],
                                       list.values[choice.value],
                                       times(choice.seconds)};
          for (const double error : choice.errors)
            row.push_back(times(error));
          row.push_back(std::to_string(choice.n_pairs));
          write_row(out, row);
        }
    }

    void
    write_orders(std::ostream     &out,
                 const StudyPlan  &plan,
                 const StudyTable &table)
    {
      const std::string label = plan.lists[plan.refined_list].label;
      out << "\n## Orders in " << label
          << "\n\nErrors fall like the size to this power: fitted to all "
             "sizes, and from each size to the next smaller one.\n";
      std::vector<std::string> head{"curve"};
      for (const StudyQuantity &quantity : plan.quantities)
        head.push_back(quantity.words);
      write_head(out, head);
      for (const StudyCurve &curve : study_curves(plan))
        {
          std::vector<std::string> row{curve.name.empty() ? "all" : curve.name};
          for (unsigned int q = 0; q < plan.quantities.size(); ++q)
            {
              std::vector<double> sizes, errors;
              for (const unsigned int m : curve.members)
                {
                  sizes.push_back(size_of(plan, m));
                  errors.push_back(table.error(m, q));
                }
              const StudyOrder         order = fit_order(sizes, errors);
              std::vector<std::string> steps;
              for (const double step : order.steps)
                steps.push_back(rounded(step));
              row.push_back(steps.empty()
                              ? "-"
                              : rounded(order.fitted) + "; " + join(steps));
            }
          write_row(out, row);
        }
    }

    void
    write_members(std::ostream     &out,
                  const StudyPlan  &plan,
                  const StudyTable &table)
    {
      out << "\n## All members\n\n**Bold**: no other one has less of both, "
             "seconds and this error. Seconds are medians of "
          << plan.repetitions << ", and longest less shortest.\n";
      std::vector<std::string> head;
      for (const StudyList &list : plan.lists)
        if (list.varies())
          head.push_back(list.name);
      for (const StudyQuantity &quantity : plan.quantities)
        head.push_back("error of " + quantity.words);
      head.insert(head.end(),
                  {"seconds", "spread", "balance error, J", "steps", "Newton"});
      write_head(out, head);
      std::vector<std::vector<bool>> is_best;
      for (unsigned int q = 0; q < plan.quantities.size(); ++q)
        is_best.push_back(pareto_front(table.all_seconds(), table.errors(q)));
      for (unsigned int m = 0; m < plan.members.size(); ++m)
        {
          std::vector<std::string> row;
          for (unsigned int i = 0; i < plan.lists.size(); ++i)
            if (plan.lists[i].varies())
              row.push_back(plan.members[m].values[i]);
          for (unsigned int q = 0; q < plan.quantities.size(); ++q)
            row.push_back(is_best[q][m]
                            ? "**" + number(table.error(m, q)) + "**"
                            : number(table.error(m, q)));
          for (const double value :
               {table.seconds(m),
                plan.repetitions > 1 ? table.spread(m) : std::nan(""),
                table.number(m, "final_balance_error"),
                table.number(m, "steps"),
                table.number(m, "total_newton_iterations")})
            row.push_back(number(value));
          write_row(out, row);
        }
      out << '\n';
      for (unsigned int m = 0; m < plan.members.size(); ++m)
        if (!table.is_done(m))
          out << "- " << plan.members[m].name << " ("
              << plan.setting(plan.members[m]) << ") " << table.state(m)
              << '\n';
    }
  } // namespace


  void
  write_study_page(std::ostream     &out,
                   const StudyPlan  &plan,
                   const StudyTable &table)
  {
    out << "# " << plan.title << '\n';
    if (!plan.purpose.empty())
      out << '\n' << plan.purpose << '\n';
    out << "\n    emmy study " << plan.file << "\n\n"
        << table.n_done() << " of " << plan.members.size()
        << " members are done. Errors are\n\n";
    for (unsigned int q = 0; q < plan.quantities.size(); ++q)
      out << definition(plan, table, q) << '\n';
    if (!plan.quantities.empty())
      {
        out << "\n![Error against seconds](error-seconds.png)\n";
        if (plan.has_sizes())
          out << "\n![Error against size](error-size.png)\n";
        write_cheapest(out, plan, table);
        if (plan.baseline >= 0)
          write_baseline(out, plan, table);
        write_choices(out, plan, table);
        if (plan.has_sizes())
          write_orders(out, plan, table);
      }
    write_members(out, plan, table);
  }


  bool
  print_cheapest(std::ostream     &out,
                 const StudyPlan  &plan,
                 const StudyTable &table,
                 const double      tolerance)
  {
    bool has_all = true;
    for (unsigned int q = 0; q < plan.quantities.size(); ++q)
      {
        const std::vector<double> errors = table.errors(q);
        const int m  = cheapest(table.all_seconds(), errors, tolerance);
        has_all      = has_all && m >= 0;
        double least = std::nan("");
        for (const double error : errors)
          least = std::fmin(least, error);
        out << plan.quantities[q].words << ": "
            << (m >= 0 ? plan.setting(plan.members[m]) + "; " +
                           brief(table.seconds(m)) + " s, error " +
                           brief(table.error(m, q))
                       : "none; the least error is " + number(least))
            << '\n';
      }
    return has_all;
  }
} // namespace emmy
