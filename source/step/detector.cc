#include <emmy/base/text.h>
#include <emmy/math/mandel.h>
#include <emmy/step/detector.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <utility>
#include <vector>

namespace emmy
{
  namespace
  {
    // The bounds of Detector, between healthy scenes and wrong columns.
    constexpr double largest_share = 3e-3, largest_overfill = 0.015,
                     largest_share_alone = 0.25, largest_overfill_alone = 0.5;
    /** Of the stored energy: less hidden motion than so much of it is none. */
    constexpr double least_kinetic_part = 1e-4;
    /** Of the kinetic energy: noise feeds on stored energy above that. */
    constexpr double least_stored_part = 0.5;
    /** So many steps on end must be beyond a bound. */
    constexpr unsigned int n_steps_on_end = 10;

    /** V0 det F of the points, m^dim. */
    template <int dim>
    std::vector<double>
    volumes(const PointArrays<dim> &points, const FieldLayout &layout)
    {
      const double *reference = points.component(layout["reference_volume"]);
      const unsigned int  less_unit = layout["left_cauchy_green_less_unit"];
      std::vector<double> result(points.n_points());
      for (std::size_t p = 0; p < result.size(); ++p)
        result[p] =
          reference[p] *
          std::sqrt(1. + mandel::determinant_less_one<dim>(
                           points.template get<n_mandel<dim>>(less_unit, p)));
      return result;
    }

    /** A number with two digits. */
    std::string
    rounded(const double number)
    {
      std::ostringstream text;
      text << std::setprecision(2) << number;
      return text.str();
    }
  } // namespace

  template <int dim>
  double
  overfill(const Stencils<dim>       &stencils,
           const PointArrays<dim>    &points,
           const PointArrays<dim>    &points_new,
           const FieldLayout         &layout,
           const ActiveGrid<dim>     &active,
           const BackgroundGrid<dim> &grid)
  {
    std::vector<double> volume = volumes(points, layout);
    if (stencils.at_middle)
      {
        const std::vector<double> volume_new = volumes(points_new, layout);
        for (std::size_t p = 0; p < volume.size(); ++p)
          volume[p] = 0.5 * (volume[p] + volume_new[p]);
      }
    std::vector<double> filled(active.n_local_nodes());
    for (const auto &group : stencils.groups)
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          const double *S   = stencils.value(group, a);
          const double *V   = volume.data() + group.first_point;
          double        sum = 0.;
          for (unsigned int p = 0; p < group.n_points; ++p)
            sum += S[p] * V[p];
          filled[active.nodes(group)[a]] += sum;
        }
    active.sum_over_ranks(filled);
    double largest = 0.;
    for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
      largest =
        std::max(largest,
                 filled[node] / grid.volume_of_node(active.position(node)));
    return dealii::Utilities::MPI::max(largest, active.communicator()) - 1.;
  }

  Detector::Detector(const RemediesInUse &in_use,
                     DetectorState       &state,
                     Told                &told)
    : in_use(in_use)
    , state(state)
    , told(told)
  {}

  void
  Detector::begin(const double overfill, StepReport &initial)
  {
    state.overfill_at_start      = std::max(0., overfill);
    state.largest_kinetic_energy = initial.totals.kinetic_energy;
    for (const auto &[name, value] :
         {std::make_pair("hidden_kinetic_energy", 0.),
          std::make_pair("hidden_share", 0.),
          std::make_pair("overfill", overfill)})
      initial.measures.push_back({name, value});
  }

  void
  Detector::look(const double       hidden,
                 const double       overfill,
                 const std::string &where,
                 StepReport        &report)
  {
    // a sum of squares; below zero only by round-off of a difference
    const double unseen = std::max(0., hidden);
    const double scale  = std::max(state.largest_kinetic_energy,
                                  least_kinetic_part * state.largest_stored);
    const double share  = scale > 0. ? unseen / scale : 0.;
    for (const auto &[name, value] :
         {std::make_pair("hidden_kinetic_energy", unseen),
          std::make_pair("hidden_share", share),
          std::make_pair("overfill", overfill)})
      report.measures.push_back({name, value});

    const std::string found = finding(unseen, share, overfill);
    if (!found.empty() && !told.detected)
      {
        told.detected = true;
        report.notes.push_back(where + ": " + found +
                               ". Results can be wrong while all balances "
                               "hold. Remedy: " +
                               remedy());
      }

    state.largest_kinetic_energy =
      std::max(state.largest_kinetic_energy, report.totals.kinetic_energy);
    for (const EnergyEntry &entry : report.energies)
      if (entry.kind == EnergyEntry::Kind::stored)
        state.stored_energy += entry.change;
    state.largest_stored = std::max(state.largest_stored, state.stored_energy);
  }

  std::string
  Detector::finding(const double hidden,
                    const double share,
                    const double overfill)
  {
    const double more = overfill - state.overfill_at_start;
    const bool   is_stored =
      state.largest_stored > least_stored_part * state.largest_kinetic_energy;
    const auto count = [](unsigned int &n, const bool is_beyond) {
      n = is_beyond ? n + 1 : 0;
      return n >= n_steps_on_end;
    };
    const bool both =
      count(state.n_both,
            is_stored && share > largest_share && more > largest_overfill);
    const bool much = count(state.n_hidden, share > largest_share_alone);
    const bool full = count(state.n_overfilled, more > largest_overfill_alone);
    std::vector<std::string> signs;
    if (both || much)
      signs.push_back("particles have " + rounded(hidden) + " J, " +
                      rounded(100. * share) +
                      " % of the largest kinetic energy, in motion that the "
                      "grid does not see");
    if (both || full)
      signs.push_back("a node holds " + rounded(100. * overfill) +
                      " % more than its place");
    return join(signs, ", and ");
  }

  std::string
  Detector::remedy() const
  {
    std::vector<std::string> settings;
    if (!in_use.gimp)
      settings.push_back("Method/Shape functions = GIMP");
    if (!in_use.middle)
      settings.push_back("Method/Geometry = middle");
    if (!in_use.followers)
      settings.push_back("Method/Starved nodes = follow");
    if (!settings.empty())
      return join(settings, " and ");
    return std::string("more Points per direction") +
           (in_use.is_dissipative
              ? ""
              : ", or Method/Mapping = blend with a Method/FLIP fraction of "
                "0.99, which takes that motion away and books it");
  }

  template double
  overfill<2>(const Stencils<2> &,
              const PointArrays<2> &,
              const PointArrays<2> &,
              const FieldLayout &,
              const ActiveGrid<2> &,
              const BackgroundGrid<2> &);
  template double
  overfill<3>(const Stencils<3> &,
              const PointArrays<3> &,
              const PointArrays<3> &,
              const FieldLayout &,
              const ActiveGrid<3> &,
              const BackgroundGrid<3> &);
} // namespace emmy
