#include <emmy/effects/advice.h>
#include <emmy/effects/field_load.h>
#include <emmy/particles/particle_layout.h>
#include <emmy/run/effect_advice.h>

#include <algorithm>
#include <ostream>

namespace emmy
{
  template <int dim>
  dealii::Tensor<1, dim>
  common_acceleration(const SceneParameters<dim> &parameters)
  {
    dealii::Tensor<1, dim> g;
    for (const std::string &name : parameters.effect_names.names)
      if (const auto *uniform = dynamic_cast<const UniformAcceleration<dim> *>(
            parameters.effects.at(name).get()))
        g += uniform->vector();
    return g;
  }

  namespace
  {
    /** What is known beforehand. Collective. */
    template <int dim>
    BeforeTheRun<dim>
    before_the_run(const Scene<dim>           &scene,
                   const SceneParameters<dim> &parameters)
    {
      BeforeTheRun<dim>                   run{{},
                            scene.grid.lower_corner(),
                            scene.grid.upper_corner(),
                            parameters.time.end_time,
                            0.,
                            scene.balance.gives_motion() ||
                              !scene.started.path.empty(),
                            scene.grid.communicator()};
      std::vector<dealii::Tensor<1, dim>> half;
      for (const Body<dim> &body : scene.bodies)
        half.push_back(initial_half_length(body, scene.grid));
      const unsigned int body = scene.layout["body"],
                         v    = scene.layout["velocity"];
      double fastest          = 0.;
      for (const auto &particle : scene.particles)
        {
          const auto             properties = particle.get_properties();
          const auto            &l          = half[properties[body]];
          dealii::Tensor<1, dim> velocity;
          for (unsigned int d = 0; d < dim; ++d)
            velocity[d] = properties[v + d];
          fastest = std::max(fastest, velocity.norm());
          for (unsigned int corner = 0; corner < (1u << dim); ++corner)
            {
              run.corners.push_back(particle.get_location());
              for (unsigned int d = 0; d < dim; ++d)
                run.corners.back()[d] += corner >> d & 1 ? l[d] : -l[d];
            }
        }
      run.flight =
        run.end_time *
        (dealii::Utilities::MPI::max(fastest, run.communicator) +
         0.5 * common_acceleration(parameters).norm() * run.end_time);
      return run;
    }
  } // namespace

  template <int dim>
  void
  tell_effect_advice(const Scene<dim>           &scene,
                     const SceneParameters<dim> &parameters,
                     std::ostream               &out)
  {
    const auto &names = parameters.effect_names.names;
    for (const std::string &name : names)
      {
        const auto *adviser =
          dynamic_cast<const Adviser<dim> *>(parameters.effects.at(name).get());
        if (!adviser)
          continue;
        BeforeTheRun<dim> run = before_the_run(scene, parameters);
        for (const std::string &other : names)
          run.is_moved_otherwise =
            run.is_moved_otherwise ||
            (other != name && !dynamic_cast<const UniformAcceleration<dim> *>(
                                parameters.effects.at(other).get()));
        for (const std::string &note : adviser->advice(run))
          out << "  note: " << note << '\n';
      }
  }

  template dealii::Tensor<1, 2>
  common_acceleration<2>(const SceneParameters<2> &);
  template dealii::Tensor<1, 3>
  common_acceleration<3>(const SceneParameters<3> &);
  template void
  tell_effect_advice<2>(const Scene<2> &,
                        const SceneParameters<2> &,
                        std::ostream &);
  template void
  tell_effect_advice<3>(const Scene<3> &,
                        const SceneParameters<3> &,
                        std::ostream &);
} // namespace emmy
