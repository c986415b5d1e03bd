#include <emmy/base/text.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/particles/body_measures.h>
#include <emmy/run/card_line.h>
#include <emmy/run/scene.h>
#include <emmy/run/scene_card.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  namespace
  {
    template <int dim>
    void
    describe_grid(const Scene<dim> &scene, std::ostream &out)
    {
      const BackgroundGrid<dim> &grid = scene.grid;
      card_line(out, "dimension") << (dim == 2 ? "2 (plane strain)\n" : "3\n");
      card_line(out, "grid")
        << dealii::Patterns::Tools::to_string(grid.n_cells()) << " cells, h = "
        << dealii::Patterns::Tools::to_string(
             dealii::Point<dim>(grid.cell_size()))
        << " m, " << grid.n_trees() << " trees\n";
      card_line(out, "ranks")
        << dealii::Utilities::MPI::n_mpi_processes(grid.communicator()) << '\n';
    }

    /** Collective. */
    template <int dim>
    void
    describe_bodies(const Scene<dim>           &scene,
                    const SceneParameters<dim> &parameters,
                    std::ostream               &out)
    {
      const auto measures =
        measure_bodies(scene.bodies, scene.grid, scene.layout, scene.particles);
      for (unsigned int b = 0; b < scene.bodies.size(); ++b)
        {
          const Body<dim> &body = scene.bodies[b];
          card_line(out, "body " + body.name)
            << parameters.material_names.names[body.material] << ", density "
            << body.density << " kg/m^3, P-wave modulus "
            << scene.material_of_body[b]->p_wave_modulus() << " Pa\n";
          for (const std::string &text :
               describe_measures(body, measures[b], scene.grid))
            text.compare(0, 5, "note:") == 0
              ? out << "  " << text << '\n'
              : card_line(out, "") << text << '\n';
          // 1e6 take a second or two
          double n_boxes = 1.;
          for (const unsigned int n : scene.grid.n_cells())
            n_boxes *= double(n) * body.points_per_direction;
          if (n_boxes > 1e6 &&
              !std::isfinite(body.shape->bounding_box().volume()))
            card_line(out, "")
              << "note: its formula was tried in all " << n_boxes
              << " boxes of the grid; the start is faster if its section "
                 "has a Lower corner and an Upper corner\n";
        }
    }

    template <int dim>
    void
    describe_method(const Scene<dim>           &scene,
                    const SceneParameters<dim> &parameters,
                    std::ostream               &out)
    {
      const MethodParameters &method = parameters.method;
      card_line(out, "method")
        << method.shape_functions
        << (scene.layout.has("half_length")
              ? " (domains: " + method.domain_update + ")"
              : std::string())
        << ", " << method.mapping << ", lumping " << scene.mapping.lumping
        << ", "
        << (scene.explicit_force ? "explicit steps with the stress at their "
                                   "start"
                                 : method.stress_rule + " stress")
        << parameters.locking_summary()
        << (scene.middle ? ", geometry in the middle of the step" : "");
      if (scene.boundary_conditions.has_walls())
        out << ", " << method.wall_mapping << " walls";
      out << '\n';
      card_line(out, "starved nodes")
        << (scene.balance.has(starved_nodes_effect) ? "follow" : "free");
      if (!parameters.why_free.empty())
        out << ": " << parameters.why_free;
      out << '\n';
      card_line(out, "effects") << (parameters.effect_names.names.empty()
                                      ? "none beyond inertia and internal force"
                                      : join(parameters.effect_names.names))
                                << '\n';
      for (const std::string &note : scene.notes)
        card_line(out, "") << note << '\n';
    }

    template <int dim>
    void
    describe_sizes(const Scene<dim> &scene,
                   const StepReport &initial,
                   const SceneCard  &card,
                   std::ostream     &out)
    {
      // a number and an index per entry
      const double       matrix_bytes = 12. * card.n_matrices * card.nonzeros;
      const unsigned int bytes        = card.particle_bytes();
      card_line(out, "particles")
        << initial.totals.particles << ", " << scene.layout.n_components()
        << " numbers each, " << bytes << " bytes, together "
        << bytes * initial.totals.particles / 1e6 << " MB\n";
      card_line(out, "work arrays")
        << card.point_bytes / 1e6 << " MB for the points of the first step, "
        << matrix_bytes / 1e6 << " MB for matrices\n";
      card_line(out, "mass") << initial.totals.mass << " kg\n";
      card_line(out, "kinetic energy")
        << std::setprecision(16) << initial.totals.kinetic_energy
        << std::setprecision(6) << " J\n";
      card_line(out, "active cells") << initial.active_cells << '\n';
      card_line(out, "unknowns") << initial.active_dofs << '\n';
    }

    void
    describe_steps(const TimeParameters &time,
                   const double          first_step,
                   std::ostream         &out)
    {
      card_line(out, "first time step") << first_step << " s\n";
      const double       n_steps = std::ceil(time.end_time / first_step);
      const unsigned int limit   = time.maximum_steps;
      card_line(out, "steps")
        << "about " << (limit > 0 ? std::min<double>(limit, n_steps) : n_steps)
        << ", to t = " << time.end_time << " s"
        << (limit > 0 ? " or the limit of steps" : "") << '\n';
    }
  } // namespace

  template <int dim>
  void
  Scene<dim>::describe(std::ostream     &out,
                       const StepReport &initial,
                       const SceneCard  &card,
                       const bool        with_absent) const
  {
    describe_grid(*this, out);
    describe_bodies(*this, parameters, out);
    describe_method(*this, parameters, out);
    describe_sizes(*this, initial, card, out);
    describe_steps(parameters.time, initial.time_step, out);
    card.print(out, with_absent);
  }

  template void
  Scene<2>::describe(std::ostream &,
                     const StepReport &,
                     const SceneCard &,
                     const bool) const;
  template void
  Scene<3>::describe(std::ostream &,
                     const StepReport &,
                     const SceneCard &,
                     const bool) const;
} // namespace emmy
