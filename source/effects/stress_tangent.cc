#include <emmy/effects/moving_places.h>
#include <emmy/effects/stress_tangent.h>

namespace emmy
{
  template <int dim>
  StressTangent<dim>::StressTangent(const StepData<dim> &step,
                                    const Iterate<dim>  &iterate,
                                    Matrix              &matrix)
    : step(step)
    , iterate(iterate)
    , matrix(matrix)
    , around(step.stencils, *step.start.active)
    , here{step.stencils, around, {}}
  {}

  template <int dim>
  void
  StressTangent<dim>::add(const PointBatch<dim> &points,
                          const Stresses        &stresses)
  {
    here.at = 0;
    for (const auto &part : points.parts)
      {
        if (!around.has(*part.group))
          {
            add_collected(stresses);
            finish();
            around.begin(*part.group);
            if (step.moving)
              step.moving->begin_neighbourhood(around,
                                               iterate.local_displacement);
            else
              stiffness.reinit(around.nodes().size());
          }
        for (unsigned int q = part.first; q < part.first + part.n_points; ++q)
          {
            here.points.push_back({part.group, q});
            if (here.points.size() == most_points_at_once)
              add_collected(stresses);
          }
      }
    add_collected(stresses);
  }

  template <int dim>
  void
  StressTangent<dim>::add_collected(const Stresses &stresses)
  {
    if (here.points.empty())
      return;
    if (step.moving)
      step.moving->add({step,
                        here,
                        stresses.batch,
                        stresses.middle,
                        stresses.volumes,
                        stresses.box_scales});
    else
      stiffness.add(here, stresses.batch, stresses.volumes);
    here.at += here.points.size();
    here.points.clear();
  }

  template <int dim>
  void
  StressTangent<dim>::finish()
  {
    if (around.nodes().empty())
      return;
    step.start.active->graph().add(around.nodes().data(),
                                   step.moving
                                     ? step.moving->finish_neighbourhood(around)
                                     : stiffness.blocks(),
                                   matrix);
  }

  template class StressTangent<2>;
  template class StressTangent<3>;
} // namespace emmy
