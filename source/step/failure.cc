#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/solve/linear_solver.h>
#include <emmy/step/failure.h>
#include <emmy/step/step_equation.h>

namespace emmy
{
  template <int dim>
  RemediesInUse
  remedies_in_use(const StepSetting<dim> &setting)
  {
    const StepMethod<dim> &method = setting.method;
    return {setting.layout.has("half_length"),
            method.middle != nullptr,
            method.balance.has(starved_nodes_effect) ||
              method.balance.has_own_map(),
            method.mapping.flip_fraction < 1.};
  }

  template <int dim>
  std::string
  usual_remedy(const StepSetting<dim> &setting)
  {
    std::vector<std::string> settings;
    if (!setting.layout.has("half_length"))
      settings.push_back("Method/Shape functions = GIMP");
    if (!setting.method.balance.has(starved_nodes_effect))
      settings.push_back("Method/Starved nodes = follow");
    return settings.empty()
             ? std::string()
             : "What helps most often: " + join(settings, " and ") + ". ";
  }

  template <int dim>
  CutVerdict
  verdict_on(const Matrix           &matrix,
             const std::string      &name,
             const Ground<dim>      &ground,
             const ActiveGrid<dim>  &active,
             const StepSetting<dim> &setting)
  {
    CutVerdict result;
    if (active.n_dofs() > largest_direct_size(dim))
      return result;
    const Diagnosis<dim> diagnosis =
      diagnose(matrix, ground.stencils, ground.points, setting.layout, active);
    const double limit = setting.method.diagnosis.report_above;
    result.weakest     = diagnosis.text(name);
    result.text        = "; " + diagnosis.verdict(name, limit);
    if (diagnosis.is_above(limit) && !diagnosis.nodes.empty())
      result.remedy =
        small_cut_remedy(setting.method.balance, setting.method.mapping);
    return result;
  }

  template <int dim>
  void
  give_up(const FailedStep<dim>  &step,
          const StepSetting<dim> &setting,
          const std::string      &where,
          FailureRecord          &record)
  {
    const FailedTry  &last   = record.tries.back();
    const std::string halved = ", with the step halved " +
                               std::to_string(setting.limits.maximum_halvings) +
                               " times to " + brief(last.time_step) + " s";
    throw_together(setting.grid.communicator(),
                   where,
                   step.leaves_grid ? last.problem + halved : std::string(),
                   "the last accepted state was kept. Enlarge the grid "
                   "(Grid/Lower corner, Upper corner), end the run earlier "
                   "(Time/End time), fix that side (Boundary conditions), or, "
                   "where it is a wall already, take smaller steps "
                   "(Time/Factor or Step size).");
    // What Newton left may be damped. Where the equation has no meaning there
    // is no derivative, but there is a mass.
    CutVerdict verdict;
    if (step.start.active->n_dofs() <= largest_direct_size(dim))
      verdict = step.equation.evaluate(step.displacement,
                                       /*with_jacobian=*/true)
                  ? verdict_on(undamped_jacobian(step.equation,
                                                 step.start,
                                                 last.time_step),
                               "Jacobian",
                               step.ground,
                               *step.start.active,
                               setting)
                  : verdict_on(examined_mass(step.start),
                               "mass matrix",
                               step.ground,
                               *step.start.active,
                               setting);
    record.weakest = verdict.weakest;
    throw_together(
      setting.grid.communicator(),
      where,
      "Newton does not converge" + halved + ": " + last.problem + verdict.text,
      "the last accepted state was kept. " + usual_remedy(setting) +
        verdict.remedy +
        "Use more Points per direction, a larger Solver/Maximum iterations, a "
        "smaller Time/Factor or Step size, or a stiffer or finer model; "
        "Time/Maximum halvings allows smaller steps.");
  }

  template RemediesInUse
  remedies_in_use<2>(const StepSetting<2> &);
  template std::string
  usual_remedy<2>(const StepSetting<2> &);
  template CutVerdict
  verdict_on<2>(const Matrix &,
                const std::string &,
                const Ground<2> &,
                const ActiveGrid<2> &,
                const StepSetting<2> &);
  template void
  give_up<2>(const FailedStep<2> &,
             const StepSetting<2> &,
             const std::string &,
             FailureRecord &);
  template RemediesInUse
  remedies_in_use<3>(const StepSetting<3> &);
  template std::string
  usual_remedy<3>(const StepSetting<3> &);
  template CutVerdict
  verdict_on<3>(const Matrix &,
                const std::string &,
                const Ground<3> &,
                const ActiveGrid<3> &,
                const StepSetting<3> &);
  template void
  give_up<3>(const FailedStep<3> &,
             const StepSetting<3> &,
             const std::string &,
             FailureRecord &);
} // namespace emmy
