#include <emmy/step/stepper.h>

// What a step tells of its matrices and its places.

namespace emmy
{
  template <int dim>
  void
  Stepper<dim>::examine(Solution &solution)
  {
    const auto &[stencils, points] = solution.ground();
    const auto diagnosis_of        = [&](const Matrix &matrix) {
      return diagnose(matrix, stencils, points, setting.layout, *start->active);
    };
    findings = std::make_unique<StepDiagnosis<dim>>();
    // Newton's last evaluation may have made no matrix
    solution.equation().evaluate(solution.displacement, /*with_jacobian=*/true);
    if (setting.method.middle)
      solution.equation().set_velocity_at_start();
    *findings = {diagnosis_of(examined_mass(*start)),
                 diagnosis_of(undamped_jacobian(solution.equation(),
                                                *start,
                                                solution.time_step))};
    for (const auto &[name, diagnosis] :
         {std::make_pair("mass matrix", &findings->mass),
          std::make_pair("Jacobian", &findings->jacobian)})
      if (diagnosis->is_above(setting.method.diagnosis.report_above))
        solution.findings.push_back(where() + ": " + diagnosis->text(name));
  }

  template <int dim>
  void
  Stepper<dim>::add_measures(const PointArrays<dim>   &points,
                             const double              time,
                             std::vector<StepMeasure> &measures)
  {
    if (setting.method.diagnosis.small_cuts)
      {
        measures.push_back(
          {"mass_condition", findings ? findings->mass.condition : 0.});
        measures.push_back(
          {"jacobian_condition", findings ? findings->jacobian.condition : 0.});
      }
    Base::add_measures(points, time, measures);
    if (!setting.method.middle)
      return;
    for (unsigned int d = dim == 2 ? 2 : 0; d < 3; ++d)
      measures.push_back({std::string("angular_momentum_left_") + "xyz"[d],
                          angular_momentum_left[d]});
    measures.push_back({"place_defect", place_defect});
  }

  template void
  Stepper<2>::examine(Solution &);
  template void
  Stepper<2>::add_measures(const PointArrays<2> &,
                           const double,
                           std::vector<StepMeasure> &);
  template void
  Stepper<3>::examine(Solution &);
  template void
  Stepper<3>::add_measures(const PointArrays<3> &,
                           const double,
                           std::vector<StepMeasure> &);
} // namespace emmy
