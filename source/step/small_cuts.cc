#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/ghost_faces.h>
#include <emmy/effects/inertia.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/step/small_cuts.h>
#include <emmy/step/step_equation.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace emmy
{
  namespace
  {
    constexpr unsigned int max_named = 3; ///< nodes, and particles of a node

    /** Less than this part of the largest is not worth a name. */
    constexpr double least_named = 0.5;

    /** To be gathered from all ranks: numbers of fixed meaning. */
    template <unsigned int n>
    using Lines = std::vector<std::array<double, n>>;

    /** All ranks' lines, the largest first; only the first few. */
    template <unsigned int n>
    Lines<n>
    largest_of_all(Lines<n> mine, const MPI_Comm communicator)
    {
      Lines<n> all;
      for (const auto &lines :
           dealii::Utilities::MPI::all_gather(communicator, mine))
        all.insert(all.end(), lines.begin(), lines.end());
      std::sort(all.begin(), all.end(), std::greater<>());
      all.resize(std::min<std::size_t>(all.size(), max_named));
      return all;
    }

    /**
     * Equal sizes differ by round-off, which depends on the partition: compare
     * what is left of two digits, then the numbers that follow.
     */
    double
    two_digits(const double number)
    {
      if (!(number > 0.))
        return 0.;
      const double unit = std::pow(10., std::floor(std::log10(number)) - 1.);
      return std::round(number / unit) * unit;
    }

    template <int dim>
    std::string
    text_of(const dealii::Point<dim> &point)
    {
      std::ostringstream text;
      text.precision(4);
      for (unsigned int d = 0; d < dim; ++d)
        text << (d == 0 ? "(" : ", ") << point[d];
      text << ')';
      return text.str();
    }

    /** The length of the vector at each local node, the largest being one. */
    template <int dim>
    std::vector<double>
    at_nodes(const Vector &weakest, const ActiveGrid<dim> &active)
    {
      const auto          local = active.to_local(weakest);
      std::vector<double> result(active.n_local_nodes());
      double              largest = 0.;
      for (unsigned int node = 0; node < result.size(); ++node)
        {
          for (unsigned int c = 0; c < dim; ++c)
            result[node] +=
              local[unknown<dim>(node, c)] * local[unknown<dim>(node, c)];
          result[node] = std::sqrt(result[node]);
          largest      = std::max(largest, result[node]);
        }
      largest = dealii::Utilities::MPI::max(largest, active.communicator());
      for (double &weakness : result)
        weakness = largest > 0. ? weakness / largest : 0.;
      return result;
    }

    /** The cells of a node and the particles that reach it. Collective. */
    template <int dim>
    void
    find_surroundings(const unsigned int      node, // local, or invalid
                      const Stencils<dim>    &stencils,
                      const PointArrays<dim> &points,
                      const double           *mass,
                      const ActiveGrid<dim>  &active,
                      WeakNode<dim>          &result)
    {
      Lines<dim>     cells;
      Lines<dim + 4> feeders; // m S to two digits, id, S, m S, position
      for (unsigned int cell = 0; cell < active.cells().size(); ++cell)
        {
          const auto &nodes = active.cell_nodes(cell);
          if (std::find(nodes.begin(), nodes.end(), node) == nodes.end())
            continue;
          const auto center = active.cells()[cell].cell->center();
          cells.emplace_back();
          for (unsigned int d = 0; d < dim; ++d)
            cells.back()[d] = center[d];
        }
      for (const auto &group : stencils.groups)
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          if (active.nodes(group)[a] == node)
            for (unsigned int q = 0; q < group.n_points; ++q)
              if (const double S = stencils.value(group, a)[q]; S > 0.)
                {
                  const std::size_t p  = group.first_point + q;
                  const double      id = stencils.particles[p]->get_id();
                  ++result.n_particles;
                  feeders.push_back(
                    {{two_digits(mass[p] * S), -id, S, mass[p] * S}});
                  for (unsigned int d = 0; d < dim; ++d)
                    feeders.back()[4 + d] = points.position(d)[p];
                }
      const MPI_Comm communicator = active.communicator();
      result.n_particles =
        dealii::Utilities::MPI::sum(result.n_particles, communicator);
      std::sort(feeders.begin(), feeders.end(), std::greater<>());
      feeders.resize(std::min<std::size_t>(feeders.size(), max_named));
      for (const auto &line : largest_of_all<dim + 4>(feeders, communicator))
        {
          dealii::Point<dim> x;
          for (unsigned int d = 0; d < dim; ++d)
            x[d] = line[4 + d];
          result.feeders.push_back(
            {static_cast<std::uint64_t>(-line[1]), x, line[2], line[3]});
        }
      Lines<dim> all;
      for (const auto &lines :
           dealii::Utilities::MPI::all_gather(communicator, cells))
        all.insert(all.end(), lines.begin(), lines.end());
      std::sort(all.begin(), all.end());
      for (const auto &line : all)
        {
          result.cells.emplace_back();
          for (unsigned int d = 0; d < dim; ++d)
            result.cells.back()[d] = line[d];
        }
    }
  } // namespace

  DiagnosisParameters::DiagnosisParameters(const std::string &path)
    : Section(path)
  {
    add_parameter("Small cuts",
                  small_cuts,
                  "Whether each step estimates the condition numbers of its "
                  "mass matrix and of Newton's matrix, scaled with their "
                  "diagonals, for the ledger, and marks the weakest nodes in "
                  "the grid files. Costs two more LU factorisations a step.");
    add_parameter("Report above",
                  report_above,
                  "With <Small cuts>: the condition number above which the "
                  "log names the weakest nodes and the particles that reach "
                  "them. Also above which the error of a step that fails does "
                  "so, with or without <Small cuts>. Dimensionless.",
                  prm,
                  dealii::Patterns::Double(1.));
  }

  EffectCard
  DiagnosisParameters::card() const
  {
    EffectCard card;
    card.name           = "diagnosis";
    card.setting        = "Diagnosis/Small cuts = true";
    card.enters         = "after Newton: two more factorisations";
    card.ledger_columns = {"mass_condition", "jacobian_condition"};
    card.grid_output    = {"mass_weakness", "jacobian_weakness"};
    card.phases         = {"diagnosis"};
    card.is_present     = small_cuts;
    return card;
  }

  template <int dim>
  ConditionEstimate
  condition_estimate(const Matrix &matrix, const ActiveGrid<dim> &active)
  {
    // waves much shorter than a cell: numbers without any order
    Vector start = active.make_vector();
    auto   entry = start.begin();
    for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
      {
        double phase = 1.;
        for (unsigned int d = 0; d < dim; ++d)
          phase += (20.3 + 7.1 * d) * active.position(node)[d] /
                   active.shortest_side();
        for (unsigned int c = 0; c < dim; ++c, ++entry)
          *entry = std::sin(phase + 1.7 * c);
      }
    return condition_estimate(matrix, active.constraints().affine(), start);
  }

  template <int dim>
  Matrix
  examined_mass(const GridStart<dim> &start)
  {
    using Conditions = typename NodalMatrix<dim>::Conditions;
    return start.active->constraints().has_followers()
             ? mass_of_unknowns(start, Conditions::worked_in, Damped::yes)
             : mass_of_unknowns(start, Conditions::left_out, Damped::no);
  }

  template <int dim>
  Matrix
  undamped_jacobian(StepEquation<dim>    &equation,
                    const GridStart<dim> &start,
                    const double          time_step)
  {
    using Conditions    = typename NodalMatrix<dim>::Conditions;
    const double factor = inertia_factor(time_step);
    Matrix       result;
    result.copy_from(equation.system().jacobian);
    result.add(-factor,
               mass_of_unknowns(start, Conditions::worked_in, Damped::yes));
    result.add(factor, examined_mass(start));
    return result;
  }

  template <int dim>
  Diagnosis<dim>
  diagnose(const Matrix           &matrix,
           const Stencils<dim>    &stencils,
           const PointArrays<dim> &points,
           const FieldLayout      &layout,
           const ActiveGrid<dim>  &active)
  {
    const ConditionEstimate estimate = condition_estimate(matrix, active);
    Diagnosis<dim>          result;
    result.condition   = estimate.condition();
    result.is_singular = estimate.is_singular();
    result.weakness    = at_nodes(estimate.weakest, active);

    // the weakest nodes of all: size, minus position, size, minus number
    Lines<dim + 3> candidates;
    for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
      if (result.weakness[node] >= least_named)
        {
          candidates.emplace_back();
          auto &line = candidates.back();
          line[0]    = two_digits(result.weakness[node]);
          for (unsigned int d = 0; d < dim; ++d)
            line[1 + d] = -active.position(node)[d];
          line[dim + 1] = result.weakness[node];
          line[dim + 2] = active.first_dof(node);
        }
    for (const auto &line :
         largest_of_all<dim + 3>(candidates, active.communicator()))
      {
        WeakNode<dim> weak;
        for (unsigned int d = 0; d < dim; ++d)
          weak.position[d] = 0. - line[1 + d]; // no -0
        weak.weakness     = line[dim + 1];
        unsigned int node = dealii::numbers::invalid_unsigned_int;
        for (unsigned int n = 0; n < active.n_local_nodes(); ++n)
          if (active.first_dof(n) == line[dim + 2])
            node = n;
        find_surroundings(node,
                          stencils,
                          points,
                          points.component(layout["mass"]),
                          active,
                          weak);
        result.nodes.push_back(weak);
      }
    return result;
  }

  template <int dim>
  std::string
  Diagnosis<dim>::text(const std::string &name) const
  {
    std::ostringstream out;
    out.precision(3);
    out << "the scaled " << name << " has the condition number " << condition;
    if (is_singular)
      out << ", singular to round-off";
    for (const WeakNode<dim> &node : nodes)
      {
        if (&node != &nodes.front())
          {
            out << (&node == &nodes[1] ? "; also " : ", ")
                << text_of(node.position);
            continue;
          }
        out << "; weakest at node " << text_of(node.position)
            << " m of the active cell" << (node.cells.size() > 1 ? "s" : "");
        for (const auto &cell : node.cells)
          out << (&cell == &node.cells.front() ? " around " : ", ")
              << text_of(cell);
        out << "; "
            << (node.n_particles == 0   ? "no particle reaches it"
                : node.n_particles == 1 ? "1 particle reaches it: "
                                        : std::to_string(node.n_particles) +
                                            " particles reach it, most: ");
        for (const auto &feeder : node.feeders)
          out << (&feeder == &node.feeders.front() ? "id " : ", id ")
              << feeder.id << " at " << text_of(feeder.position)
              << " with S = " << feeder.value;
      }
    return out.str();
  }

  template <int dim>
  bool
  Diagnosis<dim>::is_above(const double limit) const
  {
    return !(condition <= limit);
  }

  template <int dim>
  std::string
  Diagnosis<dim>::verdict(const std::string &name, const double limit) const
  {
    return is_above(limit)
             ? text(name)
             : "the scaled " + name + " has the condition number " +
                 brief(condition) + ", so no small cut is to blame";
  }

  template <int dim>
  std::string
  small_cut_remedy(const Balance<dim> &balance, const PointMapping &mapping)
  {
    std::string remedy = "Against small cuts, ";
    remedy += balance.has(starved_nodes_effect)
                ? "raise Method/Starved threshold"
                : "set Method/Starved nodes = follow";
    remedy += balance.has(ghost_effect)
                ? ", or raise Effects/Ghost stabilisation/Mass penalty"
                : ", or add ghost stabilisation (often a Mass penalty of 1e-3 "
                  "and no Stiffness penalty will do; it costs energy)";
    return remedy +
           (mapping.lumping > 0. ? ". " : ", or set Method/Lumping above 0. ");
  }

  template struct Diagnosis<2>;
  template struct Diagnosis<3>;
  template ConditionEstimate
  condition_estimate<2>(const Matrix &, const ActiveGrid<2> &);
  template ConditionEstimate
  condition_estimate<3>(const Matrix &, const ActiveGrid<3> &);
  template Matrix
  examined_mass<2>(const GridStart<2> &);
  template Matrix
  examined_mass<3>(const GridStart<3> &);
  template Matrix
  undamped_jacobian<2>(StepEquation<2> &, const GridStart<2> &, const double);
  template Matrix
  undamped_jacobian<3>(StepEquation<3> &, const GridStart<3> &, const double);
  template Diagnosis<2>
  diagnose<2>(const Matrix &,
              const Stencils<2> &,
              const PointArrays<2> &,
              const FieldLayout &,
              const ActiveGrid<2> &);
  template Diagnosis<3>
  diagnose<3>(const Matrix &,
              const Stencils<3> &,
              const PointArrays<3> &,
              const FieldLayout &,
              const ActiveGrid<3> &);
  template std::string
  small_cut_remedy<2>(const Balance<2> &, const PointMapping &);
  template std::string
  small_cut_remedy<3>(const Balance<3> &, const PointMapping &);
} // namespace emmy
