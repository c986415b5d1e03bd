#include <emmy/base/text.h>
#include <emmy/effects/field_load.h>
#include <emmy/effects/tool_parameters.h>
#include <emmy/effects/tool_path.h>
#include <emmy/run/tool_advice.h>

#include <algorithm>
#include <ostream>

namespace emmy
{
  namespace
  {
    /** The corners of all boxes of particles on this rank. */
    template <int dim>
    std::vector<dealii::Point<dim>>
    corners_of(const Scene<dim> &scene)
    {
      std::vector<dealii::Tensor<1, dim>> half;
      for (const Body<dim> &body : scene.bodies)
        half.push_back(initial_half_length(body, scene.grid));
      std::vector<dealii::Point<dim>> result;
      for (const auto &particle : scene.particles)
        for (unsigned int corner = 0; corner < (1u << dim); ++corner)
          {
            const unsigned int b =
              particle.get_properties()[scene.layout["body"]];
            result.push_back(particle.get_location());
            for (unsigned int d = 0; d < dim; ++d)
              result.back()[d] += corner >> d & 1 ? half[b][d] : -half[b][d];
          }
      return result;
    }

    /** How far bodies fly in a run, m. Collective. */
    template <int dim>
    double
    flight(const Scene<dim> &scene, const SceneParameters<dim> &parameters)
    {
      dealii::Tensor<1, dim> g;
      for (const std::string &name : parameters.effect_names.names)
        if (const auto *uniform =
              dynamic_cast<const UniformAcceleration<dim> *>(
                parameters.effects.at(name).get()))
          g += uniform->vector();
      double             fastest = 0.;
      const unsigned int first   = scene.layout["velocity"];
      for (const auto &particle : scene.particles)
        {
          dealii::Tensor<1, dim> v;
          for (unsigned int d = 0; d < dim; ++d)
            v[d] = particle.get_properties()[first + d];
          fastest = std::max(fastest, v.norm());
        }
      fastest = dealii::Utilities::MPI::max(fastest, scene.grid.communicator());
      const double end = parameters.time.end_time;
      return fastest * end + 0.5 * g.norm() * end * end;
    }

    /** Whether something but tools, gravity and their velocity moves bodies. */
    template <int dim>
    bool
    moves_otherwise(const Scene<dim>           &scene,
                    const SceneParameters<dim> &parameters)
    {
      const std::vector<std::string> harmless{
        "gravity", "tools", "contact", "mass damping", "viscous sides"};
      const auto &names = parameters.effect_names.names;
      return scene.balance.gives_motion() || !scene.started.path.empty() ||
             std::any_of(names.begin(), names.end(), [&](const auto &name) {
               return std::count(harmless.begin(), harmless.end(), name) == 0;
             });
    }
  } // namespace

  template <int dim>
  void
  tell_tools(const Scene<dim>           &scene,
             const SceneParameters<dim> &parameters,
             std::ostream               &out)
  {
    const auto &names = parameters.effect_names.names;
    if (std::count(names.begin(), names.end(), "tools") == 0)
      return;
    const auto &tools = dynamic_cast<const ToolsParameters<dim> &>(
                          *parameters.effects.at("tools"))
                          .given();
    const auto     points       = corners_of(scene);
    const double   flies        = flight(scene, parameters);
    const MPI_Comm communicator = scene.grid.communicator();
    // a tool may be met by what another one moves
    unsigned int n_moving  = 0;
    const bool   by_others = moves_otherwise(scene, parameters);
    struct Seen
    {
      std::string           name;
      double                gap;
      std::optional<double> outside;
      bool                  moves;
    };
    std::vector<Seen> seen;
    for (const auto &tool : tools)
      {
        if (tool->is_pushed() || tool->is_holding())
          {
            ++n_moving;
            continue;
          }
        const auto          shape  = tool->make_shape();
        const auto          motion = tool->make_motion();
        const ToolPath<dim> path(*shape, motion, parameters.time.end_time);
        seen.push_back(
          {tool->name,
           dealii::Utilities::MPI::min(path.least_gap(points), communicator),
           path.outside_since(scene.grid.lower_corner(),
                              scene.grid.upper_corner()),
           path.moves()});
        n_moving += path.moves();
      }
    for (const auto &[name, gap, outside, moves] : seen)
      {
        if (outside)
          out << "  note: tool <" << name << "> is outside of the grid "
              << (*outside > 0. ? "from about t = " + brief(*outside) + " s on"
                                : std::string("all the time"))
              << " and touches nothing there\n";
        else if (gap > flies && (moves || (n_moving == 0 && !by_others)))
          out << "  note: tool <" << name << "> comes no nearer than "
              << brief(gap)
              << " m to particles as they stand at the start: it touches only "
                 "what comes to it. Are its Reference point, its Displacement "
                 "and the direction of its normal or axis right?\n";
      }
  }

  template void
  tell_tools<2>(const Scene<2> &, const SceneParameters<2> &, std::ostream &);
  template void
  tell_tools<3>(const Scene<3> &, const SceneParameters<3> &, std::ostream &);
} // namespace emmy
