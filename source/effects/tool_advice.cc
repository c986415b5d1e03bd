#include <emmy/base/text.h>
#include <emmy/effects/tool_parameters.h>
#include <emmy/effects/tool_path.h>

namespace emmy
{
  namespace
  {
    /** What is known of a tool's way. */
    struct Outlook
    {
      std::string           name;
      double                gap;     ///< to what rests, at least, m
      std::optional<double> outside; ///< of the grid from then on, s
      bool                  moves;
    };
  } // namespace

  template <int dim>
  std::vector<std::string>
  ToolsParameters<dim>::advice(const BeforeTheRun<dim> &run) const
  {
    // a tool may be met by what another one moves
    bool                 others_move = run.is_moved_otherwise;
    std::vector<Outlook> outlooks;
    for (const auto &tool : tools)
      {
        if (tool->is_pushed() || tool->is_holding())
          {
            others_move = true;
            continue;
          }
        const auto          shape  = tool->make_shape();
        const auto          motion = tool->make_motion();
        const ToolPath<dim> path(*shape, motion, run.end_time);
        outlooks.push_back(
          {tool->name,
           dealii::Utilities::MPI::min(path.least_gap(run.corners),
                                       run.communicator),
           path.outside_since(run.lower, run.upper),
           path.moves()});
        others_move = others_move || path.moves();
      }
    std::vector<std::string> notes;
    for (const auto &[name, gap, outside, moves] : outlooks)
      if (outside)
        notes.push_back("tool <" + name + "> is outside of the grid " +
                        (*outside > 0.
                           ? "from about t = " + brief(*outside) + " s on"
                           : std::string("all the time")) +
                        " and touches nothing there");
      else if (gap > run.flight && (moves || !others_move))
        notes.push_back(
          "tool <" + name + "> comes no nearer than " + brief(gap) +
          " m to particles as they stand at the start: it touches only what "
          "comes to it. Are its Reference point, its Displacement and the "
          "direction of its normal or axis right?");
    return notes;
  }

  template std::vector<std::string>
  ToolsParameters<2>::advice(const BeforeTheRun<2> &) const;
  template std::vector<std::string>
  ToolsParameters<3>::advice(const BeforeTheRun<3> &) const;
} // namespace emmy
