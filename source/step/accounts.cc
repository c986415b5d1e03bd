#include <emmy/step/accounts.h>

namespace emmy
{
  namespace
  {
    /** Works of residuals and walls, and the loss of inelastic walls. */
    template <int dim>
    void
    add_works(const GridStart<dim>    &start,
              const StepEquation<dim> &equation,
              const PointMapping      &mapping,
              const Vector            &displacement,
              const Vector            &velocity_new,
              StepAccounts            &result)
    {
      // a vector's part on free unknowns, and that on fixed ones; followers
      // have handed theirs over
      const auto split = [&start](Vector vector) {
        const Constraints &constraints = start.active->constraints();
        constraints.fold(vector);
        std::pair<Vector, Vector> parts(vector, vector);
        constraints.set_zero(parts.first);
        parts.second -= parts.first;
        return parts;
      };
      const auto misfit_of = [&start](const Vector &velocity) {
        Vector misfit = start.momentum;
        start.mass.residual(misfit, velocity, start.momentum);
        return misfit;
      };

      result.residual_work = equation.residual() * displacement;
      result.reaction_work =
        split(equation.unconstrained_residual()).second * displacement;

      Vector change = velocity_new;
      change -= start.mapped_velocity;
      Vector misfit = misfit_of(start.mapped_velocity);
      switch (mapping.walls)
        {
          case PointMapping::Walls::constrained:
            {
              // what the map leaves on fixed unknowns is the walls' impulse
              const auto [free, fixed] = split(misfit);
              result.residual_work += free * change;
              result.reaction_work += fixed * change;
              break;
            }
          case PointMapping::Walls::unconstrained:
            result.residual_work += misfit * change;
            break;
          case PointMapping::Walls::inelastic:
            {
              result.residual_work += misfit * change;
              // M~ w is the impulse with which the walls stop the grid
              Vector impulse = misfit_of(start.velocity);
              impulse -= misfit;
              Vector stopped = start.mapped_velocity;
              stopped -= start.velocity;
              const auto [free, fixed] = split(impulse);
              result.wall_loss         = 0.5 * (stopped * impulse);
              result.residual_work -= start.velocity * free;
              result.reaction_work -= start.velocity * fixed;
              break;
            }
        }
    }

    template <int dim>
    void
    add_mapping_losses(const StepData<dim> &step,
                       const FieldLayout   &layout,
                       const PointMapping  &mapping,
                       const Vector        &velocity_new,
                       StepAccounts        &result)
    {
      const GridStart<dim> &start = step.start;
      const auto            v_new = start.active->to_local(velocity_new);
      const auto    v_mapped = start.active->to_local(start.mapped_velocity);
      const double *mass     = step.points.component(layout["mass"]);
      const unsigned int velocity = layout["velocity"];
      const double       alpha    = mapping.flip_fraction;

      double lumping = 0., pic = 0.;
      for (const auto &group : step.stencils.groups)
        for (unsigned int q = 0; q < group.n_points; ++q)
          {
            const std::size_t      p = group.first_point + q;
            dealii::Tensor<1, dim> change, w, d;
            double                 mean_square = 0.;
            for (unsigned int c = 0; c < dim; ++c)
              d[c] = step.points.component(velocity + c)[p];
            for (unsigned int a = 0; a < group.n_nodes; ++a)
              {
                const double       S    = step.stencils.value(group, a)[q];
                const unsigned int node = start.active->nodes(group)[a];
                for (unsigned int c = 0; c < dim; ++c)
                  {
                    const double v0 = v_mapped[dim * node + c],
                                 v1 = v_new[dim * node + c];
                    change[c] += S * (v1 - v0);
                    mean_square += S * (v1 - v0) * (v1 - v0);
                    w[c] += S * v1;
                    d[c] -= S * v0;
                  }
              }
            lumping += mass[p] * (mean_square - change.norm_square());
            pic += mass[p] * (w * d + 0.5 * (1. + alpha) * d.norm_square());
          }
      const MPI_Comm communicator = start.active->communicator();
      result.lumping_loss         = 0.5 * mapping.lumping *
                            dealii::Utilities::MPI::sum(lumping, communicator);
      result.mapping_loss =
        (1. - alpha) * dealii::Utilities::MPI::sum(pic, communicator);
    }
  } // namespace

  template <int dim>
  StepAccounts
  accounts(const StepData<dim>     &step,
           const StepEquation<dim> &equation,
           const FieldLayout       &layout,
           const PointMapping      &mapping,
           const Vector            &displacement,
           const Vector            &velocity_new)
  {
    StepAccounts result;
    add_works(
      step.start, equation, mapping, displacement, velocity_new, result);
    if (mapping.lumping > 0. || mapping.flip_fraction < 1.)
      add_mapping_losses(step, layout, mapping, velocity_new, result);
    if (step.start.ghost_matrices[0].m() > 0)
      {
        Vector change = velocity_new;
        change -= step.start.mapped_velocity;
        result.ghost_mass_loss =
          0.5 * dealii::Utilities::MPI::sum(
                  step.start.ghost_product(change, &GhostFace<dim>::mass),
                  step.start.active->communicator());
      }
    return result;
  }

  template StepAccounts
  accounts<2>(const StepData<2> &,
              const StepEquation<2> &,
              const FieldLayout &,
              const PointMapping &,
              const Vector &,
              const Vector &);
  template StepAccounts
  accounts<3>(const StepData<3> &,
              const StepEquation<3> &,
              const FieldLayout &,
              const PointMapping &,
              const Vector &,
              const Vector &);
} // namespace emmy
