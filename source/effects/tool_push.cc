#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/base/text.h>
#include <emmy/effects/moving_places.h>
#include <emmy/effects/tool_push.h>

#include <cmath>
#include <limits>

namespace emmy
{
  using dealii::Tensor;
  using dealii::Patterns::Double;

  template <int dim>
  double
  ToolPush<dim>::force(const double time) const
  {
    const double value = formula->value(dealii::Point<1>(time));
    AssertThrow(std::isfinite(value),
                ExcRun(section,
                       "Force is " + shortest(value) +
                         " at t = " + shortest(time) + " s",
                       "correct it: it must be finite at all times of the "
                       "run. What was written so far is kept."));
    return value;
  }

  template <int dim>
  void
  ToolPushParameters<dim>::declare(Section &section)
  {
    section.add_parameter("Pushed along",
                          direction,
                          "Direction in which <Force> pushes the tool; its "
                          "length does not matter. The tool then moves along "
                          "it as force, mass and bodies let it, and across it "
                          "as <Displacement> says. Empty: it is not pushed.",
                          section.prm,
                          dealii::Patterns::List(Double(), 0, dim));
    section.add_parameter("Force",
                          force,
                          "That pushes it, a formula in t (s). Unit: N; in "
                          "plane strain N per metre of thickness. Required "
                          "with <Pushed along>.");
    section.add_parameter("Mass",
                          mass,
                          "Of a tool that is pushed; <Force> has its weight "
                          "if it is to have one. Unit: kg; in plane strain kg "
                          "per metre of thickness. Required with <Pushed "
                          "along>, positive.",
                          section.prm,
                          Double());
    section.add_parameter("Initial speed",
                          initial_speed,
                          "Of a tool that is pushed, along that direction. "
                          "Unit: m/s.",
                          section.prm,
                          Double());
  }

  template <int dim>
  std::optional<ToolPush<dim>>
  ToolPushParameters<dim>::make(const Section &section) const
  {
    const auto require = [&section](const bool         fact,
                                    const std::string &entry,
                                    const std::string &value,
                                    const std::string &what) {
      AssertThrow(fact, ExcParameter(section.path(), entry, value, what));
    };
    if (!is_given())
      {
        const std::string what =
          "nothing pushes the tool. Give the direction in <Pushed along>, or "
          "remove it.";
        require(dealii::Utilities::trim(force).empty(), "Force", force, what);
        require(mass == 0., "Mass", shortest(mass), what);
        require(initial_speed == 0.,
                "Initial speed",
                shortest(initial_speed),
                what);
        return {};
      }
    require(mass > 0.,
            "Mass",
            shortest(mass),
            "it is required for a tool that is pushed, and must be positive "
            "(kg). A small one follows the force at once.");
    const std::string remedy = "Write a formula in t, the time (s), e.g. "
                               "1000*min(t, 1).";
    require(!dealii::Utilities::trim(force).empty(),
            "Force",
            "",
            "it is required for a tool that is pushed. " + remedy);
    return ToolPush<dim>{
      direction_of<dim>(section, "Pushed along", direction),
      mass,
      initial_speed,
      section.path(),
      read_formulas<1>(force, 1, section.path(), "Force", remedy, "t")};
  }

  template <int dim>
  PushMotion
  pushed_motion(const ToolPush<dim>                               &push,
                const PushState                                   &state,
                const double                                       time,
                const double                                       dt,
                const std::function<PushResistance(const double)> &resistance)
  {
    constexpr unsigned int most      = 200;
    constexpr double       round_off = std::numeric_limits<double>::epsilon();

    const double inertia = 2. * push.mass / (dt * dt);
    const double P       = push.force(time + 0.5 * dt);
    double       least   = -std::numeric_limits<double>::infinity();
    double       largest = -least;
    PushMotion   result;
    result.way = dt * state.speed + P / inertia; // if nothing resists
    for (unsigned int i = 0; i < most; ++i)
      {
        const double         D    = result.way;
        const PushResistance here = resistance(D);
        const double rho = inertia * (D - dt * state.speed) - P + here.force;
        const double size =
          inertia * (std::abs(D) + dt * std::abs(state.speed)) + std::abs(P) +
          here.magnitudes;
        // never without resistance, also where a surface turns away
        result.stiffness = std::max(inertia + here.stiffness, 0.1 * inertia);
        (rho > 0. ? largest : least) = D;
        const double next            = D - rho / result.stiffness;
        if (std::abs(rho) <= 8. * round_off * size || next == D)
          return result;
        result.way =
          next > least && next < largest ? next : 0.5 * (least + largest);
        if (result.way == D)
          return result; // not between two numbers
      }
    result.problem = push.section + ": the way of the tool that is pushed was "
                                    "not found";
    return result;
  }

  template <int dim>
  PushCoupling<dim>::PushCoupling(const StepData<dim>       &step,
                                  const std::vector<double> &displacement,
                                  const Tensor<1, dim>      &direction)
    : step(step)
    , displacement(displacement)
    , direction(direction)
    , by_way(displacement.size())
    , by_nodes(displacement.size())
  {}

  template <int dim>
  void
  PushCoupling<dim>::add(const CornerMotion<dim> &particle,
                         const Tensor<1, dim>    &arm,
                         const Tensor<2, dim>    &derivative)
  {
    acts                        = true;
    const Tensor<1, dim> by_D   = -1. * (derivative * direction);
    const Tensor<1, dim> by_dy  = direction * derivative;
    const Tensor<1, dim> by_arm = // of an arm of the middle, too
      by_dy + 0.5 * (by_dy * (particle.gradient * particle.Z));
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int l = 0; l <= dim; ++l)
        {
          const unsigned int row = (dim + 1) * i + l;
          forces_by_way[row] += (l == 0 ? 1. : arm[l - 1]) * by_D[i];
          force_by_motion[row] += l == 0 ? by_dy[i] : by_arm[i] * arm[l - 1];
        }
  }

  template <int dim>
  void
  PushCoupling<dim>::finish(const Group &group, const unsigned int q)
  {
    if (!acts)
      return;
    touches                   = true;
    const unsigned int *nodes = step.start.active->nodes(group);
    const auto       followed = followed_motion(step, group, q, displacement);
    PointMotion<dim> by_weights{}; // e.f by W du
    for (unsigned int row = 0; row < by_weights.size(); ++row)
      {
        shift += force_by_motion[row] * followed.shift[row];
        for (unsigned int column = 0; column < by_weights.size(); ++column)
          by_weights[column] +=
            force_by_motion[row] * followed.by_nodes[row][column];
      }
    for (unsigned int a = 0; a < group.n_nodes; ++a)
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int l = 0; l <= dim; ++l)
          {
            const double weight =
              l == 0 ? step.stencils.value(group, a)[q]
                     : step.stencils.gradient(group, a, l - 1)[q];
            const unsigned int node = unknown<dim>(nodes[a], i),
                               row  = (dim + 1) * i + l;
            by_way[node] -= weight * forces_by_way[row];
            by_nodes[node] += weight * by_weights[row];
          }
    acts            = false;
    forces_by_way   = {};
    force_by_motion = {};
  }

  template <int dim>
  void
  PushCoupling<dim>::finish(const double          stiffness,
                            std::vector<RankOne> &terms) const
  {
    using namespace dealii::Utilities::MPI;
    const ActiveGrid<dim> &active = *step.start.active;
    if (max(touches ? 1 : 0, active.communicator()) == 0)
      return;
    if (step.moving)
      {
        const double D     = -sum(shift, active.communicator()) / stiffness;
        auto         share = by_way;
        for (double &entry : share)
          entry *= D;
        step.moving->add_to_share(share);
      }
    RankOne term{active.make_vector(), active.make_vector()};
    active.add(by_way, term.column);
    active.add(by_nodes, term.row);
    active.constraints().condense(term.column);
    active.constraints().condense(term.row);
    term.row *= -1. / stiffness;
    terms.push_back(std::move(term));
  }

#define INSTANTIATE(dim)                   \
  template struct ToolPush<dim>;           \
  template struct ToolPushParameters<dim>; \
  template class PushCoupling<dim>;        \
  template PushMotion pushed_motion<dim>(  \
    const ToolPush<dim> &,                 \
    const PushState &,                     \
    const double,                          \
    const double,                          \
    const std::function<PushResistance(const double)> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
