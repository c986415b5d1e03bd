#include <emmy/base/exceptions.h>
#include <emmy/study/ledger_history.h>

#include <deal.II/base/utilities.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace emmy
{
  LedgerHistory::LedgerHistory(const std::string &filename)
  {
    std::ifstream file(filename);
    std::string   line;
    std::getline(file, line);
    names = dealii::Utilities::split_string_list(line, ',');
    columns.resize(names.size());
    bool is_whole = !names.empty();
    while (is_whole && std::getline(file, line))
      {
        const auto words = dealii::Utilities::split_string_list(line, ',');
        is_whole         = words.size() == names.size();
        for (unsigned int c = 0; is_whole && c < words.size(); ++c)
          columns[c].push_back(std::strtod(words[c].c_str(), nullptr));
      }
    AssertThrow(is_whole && !columns[0].empty() && has("time"),
                ExcRun("Study",
                       "cannot read <" + filename + ">",
                       "remove its folder, or run with --overwrite."));
    if (has("kinetic_energy") && has("strain_energy"))
      derive_energies();
  }


  bool
  LedgerHistory::has(const std::string &column) const
  {
    return std::find(names.begin(), names.end(), column) != names.end();
  }


  const std::vector<double> &
  LedgerHistory::column(const std::string &name) const
  {
    return columns[std::find(names.begin(), names.end(), name) - names.begin()];
  }


  void
  LedgerHistory::derive_energies()
  {
    const auto sum = [this](const std::vector<std::string> &parts) {
      std::vector<double> result(columns[0].size(), 0.);
      for (const std::string &part : parts)
        if (has(part))
          std::transform(result.begin(),
                         result.end(),
                         column(part).begin(),
                         result.begin(),
                         std::plus<>());
      return result;
    };
    const auto total =
      sum({"kinetic_energy", "strain_energy", "hardening_energy"});
    const auto          works       = sum({"load_work", "reaction_work"});
    const auto          dissipation = sum({"plastic_dissipation"});
    const double        largest = *std::max_element(total.begin(), total.end());
    std::vector<double> lost, share;
    for (unsigned int row = 0; row < total.size(); ++row)
      {
        lost.push_back(total[0] + works[row] - dissipation[row] - total[row]);
        share.push_back(largest > 0. ? lost.back() / largest : 0.);
      }
    for (const auto &[name, values] : {std::make_pair("total_energy", total),
                                       std::make_pair("lost_energy", lost),
                                       std::make_pair("lost_share", share)})
      {
        names.push_back(name);
        columns.push_back(values);
      }
  }
} // namespace emmy
