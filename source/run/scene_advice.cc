#include <deal.II/base/timer.h>
#include <deal.II/base/utilities.h>

#include <emmy/base/text.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/particles/particle_layout.h>
#include <emmy/run/card_line.h>
#include <emmy/run/cheaper.h>
#include <emmy/run/effect_advice.h>
#include <emmy/run/load_waves.h>
#include <emmy/run/scene_advice.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace emmy
{
  namespace
  {
    template <int dim>
    double
    smallest(const dealii::Tensor<1, dim> &h)
    {
      double result = h[0];
      for (unsigned int d = 1; d < dim; ++d)
        result = std::min(result, h[d]);
      return result;
    }

    template <int dim>
    void
    tell_waves(const Scene<dim> &scene,
               const StepReport &initial,
               std::ostream     &out)
    {
      const double h =
        smallest<dim>(scene.grid.size_at(scene.grid.lower_corner()));
      for (unsigned int b = 0; b < scene.bodies.size(); ++b)
        {
          const double speed =
            std::sqrt(scene.material_of_body[b]->p_wave_modulus() /
                      scene.bodies[b].density);
          const double by_step = steps_per_period * speed * initial.time_step;
          card_line(out, b == 0 ? "shortest waves" : "")
            << "body " << scene.bodies[b].name << ": P-waves run "
            << brief(speed) << " m/s, " << brief(speed * initial.time_step / h)
            << " cells a step; " << steps_per_period
            << " steps a period resolve waves of " << brief(by_step / h)
            << " cells and more, the grid " << cells_per_wave << '\n';
        }
      for (const unsigned int b :
           bodies_without_waves(scene, initial.time_step))
        out << "  note: such steps do not show even the slowest P-waves of "
               "body <"
            << scene.bodies[b].name
            << ">. That is right for motions that are slow against them. Where "
               "bodies hit or loads jump take steps of "
            << brief(h * std::sqrt(scene.bodies[b].density /
                                   scene.material_of_body[b]->p_wave_modulus()))
            << " s (normalised, Factor = 1) or less\n";
    }

    /** Numbers that fit no solid in SI units. Empty: they may. */
    std::string
    suspicion(const double density, const double modulus)
    {
      const double speed = std::sqrt(modulus / density);
      if (density < 1e-5)
        return "a density of " + brief(density) +
               " kg/m^3 is that of no solid; t/mm^3 and g/mm^3 are 1e12 and "
               "1e6 kg/m^3";
      if (speed > 2.5e4)
        return "P-waves of " + brief(speed) +
               " m/s are faster than in any solid. Is the density in g/cm^3 "
               "(1000 kg/m^3), or the modulus in other units than Pa?";
      if (density > 2000. && speed < 20.)
        return "P-waves of " + brief(speed) +
               " m/s are slow for a density of " + brief(density) +
               " kg/m^3. Is the modulus in MPa (1e6 Pa) or GPa?";
      return "";
    }

    template <int dim>
    void
    tell_units(const Scene<dim> &scene, std::ostream &out)
    {
      for (unsigned int b = 0; b < scene.bodies.size(); ++b)
        {
          const Body<dim> &body   = scene.bodies[b];
          const double modulus    = scene.material_of_body[b]->p_wave_modulus();
          const std::string words = suspicion(body.density, modulus);
          if (!words.empty())
            out << "  note: body <" << body.name << ">: " << words << '\n';
          // a metal whose measures are tens of metres: millimetres
          const double extent =
            smallest<dim>(scene.grid.size_at(scene.grid.lower_corner()));
          if (body.density > 2000. && modulus > 1e10 && extent > 1.)
            out << "  note: body <" << body.name << "> has cells of "
                << brief(extent)
                << " m and the modulus of a metal or rock. Are lengths in mm? "
                   "emmy takes m, kg, s\n";
        }
    }

    /** Bodies that their own weight would crush. */
    template <int dim>
    void
    tell_weights(const Scene<dim>           &scene,
                 const SceneParameters<dim> &parameters,
                 std::ostream               &out)
    {
      constexpr double             largest_strain = 0.2;
      const dealii::Tensor<1, dim> g = common_acceleration(parameters);
      for (unsigned int b = 0; b < scene.bodies.size(); ++b)
        {
          if (!scene.material_of_body[b]->parameters().empty())
            continue; // its modulus is one of many
          const Body<dim> &body = scene.bodies[b];
          const auto       box  = body.shape->bounding_box();
          const auto       size =
            scene.grid.upper_corner() - scene.grid.lower_corner();
          double weight = 0.; // rho g H, Pa
          for (unsigned int d = 0; d < dim; ++d)
            if (g[d] != 0.)
              weight += body.density * std::abs(g[d]) *
                        std::min(box.side_length(d), size[d]);
          const double modulus = scene.material_of_body[b]->p_wave_modulus();
          if (weight > largest_strain * modulus)
            out << "  note: body <" << body.name
                << ">: its weight, density times acceleration times height, is "
                << brief(weight) << " Pa, of a P-wave modulus of "
                << brief(modulus) << " Pa, and would squeeze it by more than "
                << brief(100. * largest_strain)
                << " %. Is the modulus in kPa or MPa, or the density not in "
                   "kg/m^3?\n";
        }
    }

    template <int dim>
    struct Counts
    {
      std::uint64_t on_faces = 0, cells = 0;
      /** Particles whose boxes have a corner in another body, and two names. */
      std::uint64_t overlaps = 0;
      std::string   first, second;
      /** Sides of the grid whose cells hold particles, as 1. */
      std::vector<unsigned int> at_side = std::vector<unsigned int>(2 * dim);
    };

    /** Whether the box around a point has a corner in a shape. */
    template <int dim>
    bool
    reaches(const dealii::Point<dim>     &center,
            const dealii::Tensor<1, dim> &half,
            const Shape<dim>             &shape)
    {
      for (unsigned int corner = 0; corner < (1u << dim); ++corner)
        {
          dealii::Point<dim> x = center;
          for (unsigned int d = 0; d < dim; ++d) // bodies may touch
            x[d] += (corner >> d & 1 ? 1. : -1.) * (1. - 1e-6) * half[d];
          if (shape.contains(x))
            return true;
        }
      return false;
    }

    /**
     * How far the boxes of a body's particles reach beside their centres, m,
     * by the other body: zero where both divide the cells alike, as their boxes
     * never overlap then.
     */
    template <int dim>
    std::vector<std::vector<dealii::Tensor<1, dim>>>
    reaches_of_boxes(const Scene<dim> &scene)
    {
      std::vector<bool> divides_cells;
      for (const Body<dim> &body : scene.bodies)
        divides_cells.push_back(
          body.shape->table() == nullptr &&
          !ParticleLayout<dim>(body, scene.grid).divides_body());
      const std::size_t                                n = scene.bodies.size();
      std::vector<std::vector<dealii::Tensor<1, dim>>> result(
        n, std::vector<dealii::Tensor<1, dim>>(n));
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b)
          if (!divides_cells[a] || !divides_cells[b] ||
              scene.bodies[a].points_per_direction !=
                scene.bodies[b].points_per_direction)
            result[a][b] = initial_half_length(scene.bodies[a], scene.grid);
      return result;
    }

    /** Collective; the names are those of this rank. */
    template <int dim>
    Counts<dim>
    count(const Scene<dim> &scene)
    {
      Counts<dim>            counts;
      std::set<CellKey<dim>> cells;
      const auto             half = reaches_of_boxes(scene);
      for (const auto &particle : scene.particles)
        {
          const auto  key = scene.grid.key_of(particle.get_surrounding_cell());
          const auto &x   = particle.get_location();
          const auto  place      = scene.grid.reference_position(key, x);
          bool        is_on_face = false;
          for (unsigned int d = 0; d < dim; ++d)
            is_on_face =
              is_on_face || place[d] < 1e-12 || place[d] > 1. - 1e-12;
          counts.on_faces += is_on_face;
          for (unsigned int d = 0; d < dim; ++d)
            {
              const double h = scene.grid.size_of(key)[d];
              if (x[d] < scene.grid.lower_corner()[d] + h)
                counts.at_side[2 * d] = 1;
              if (x[d] > scene.grid.upper_corner()[d] - h)
                counts.at_side[2 * d + 1] = 1;
            }
          cells.insert(key);
          const unsigned int b =
            particle.get_properties()[scene.layout["body"]];
          for (unsigned int other = 0; other < scene.bodies.size(); ++other)
            if (other != b &&
                reaches<dim>(x, half[b][other], *scene.bodies[other].shape))
              {
                ++counts.overlaps;
                counts.first  = scene.bodies[b].name;
                counts.second = scene.bodies[other].name;
              }
        }
      const MPI_Comm communicator = scene.grid.communicator();
      counts.cells =
        dealii::Utilities::MPI::sum(std::uint64_t(cells.size()), communicator);
      counts.on_faces =
        dealii::Utilities::MPI::sum(counts.on_faces, communicator);
      counts.overlaps =
        dealii::Utilities::MPI::sum(counts.overlaps, communicator);
      dealii::Utilities::MPI::max(counts.at_side, communicator, counts.at_side);
      return counts;
    }

    /** Walls that hold nothing yet: a floor below, or a mistake. */
    template <int dim>
    void
    tell_walls(const Scene<dim>  &scene,
               const Counts<dim> &counts,
               std::ostream      &out)
    {
      std::vector<std::string> idle;
      for (unsigned int side = 0; side < 2 * dim; ++side)
        if (scene.boundary_conditions.fixed_components_of(side).any() &&
            counts.at_side[side] == 0)
          idle.push_back(side_names(dim)[side]);
      if (!idle.empty())
        card_line(out, "walls")
          << join(idle) << ": no body lies in their cells at the start\n";
    }

    /** Nodes that follow others, by the bodies that reach them. */
    template <int dim>
    std::vector<std::set<dealii::types::global_dof_index>>
    starved_nodes(const Scene<dim> &scene)
    {
      const auto stencils =
        scene.shape_functions->evaluate(scene.particles, scene.grid);
      const auto points = gather(stencils, scene.layout);
      scene.balance.classify(stencils, points, scene.grid, nullptr);
      const auto couplings = scene.balance.couplings(stencils,
                                                     scene.grid,
                                                     scene.boundary_conditions,
                                                     nullptr);
      std::set<dealii::types::global_dof_index> tied;
      for (const TiedNode<dim> &node : couplings.tied_nodes)
        tied.insert(node.id);
      std::vector<std::set<dealii::types::global_dof_index>> result(
        scene.bodies.size());
      for (const auto &group : stencils.groups)
        for (unsigned int i = 0; i < group.n_nodes; ++i)
          if (const auto id = stencils.node_ids[group.first_node + i];
              tied.count(id) > 0)
            result[group.body].insert(id);
      return result;
    }

    /** How many nodes starve at the start, and where one is. Collective. */
    template <int dim>
    void
    tell_starved(const Scene<dim> &scene, std::ostream &out)
    {
      if (!scene.balance.has(starved_nodes_effect))
        return;
      using Places     = std::vector<std::array<double, dim>>;
      const auto found = starved_nodes(scene);
      std::vector<Places>
        places; // by body; ranks number nodes in their own way
      for (const auto &ids : found)
        {
          places.emplace_back();
          for (const auto id : ids)
            {
              const auto x = scene.grid.node_position(id);
              std::copy_n(x.begin_raw(),
                          dim,
                          places.back().emplace_back().begin());
            }
        }
      const auto of_ranks =
        dealii::Utilities::MPI::gather(scene.grid.communicator(), places);
      bool is_first = true;
      for (unsigned int b = 0; b < scene.bodies.size(); ++b)
        {
          std::set<std::array<double, dim>>
            all; // nodes between ranks count once
          for (const auto &of_rank : of_ranks)
            all.insert(of_rank[b].begin(), of_rank[b].end());
          if (all.empty())
            continue;
          card_line(out, is_first ? "starved at the start" : "")
            << "body " << scene.bodies[b].name << ": " << all.size()
            << " follow others, the first at (";
          for (unsigned int d = 0; d < dim; ++d)
            out << (d > 0 ? ", " : "") << brief((*all.begin())[d]);
          out << ") m\n";
          is_first = false;
        }
      if (is_first)
        card_line(out, "starved at the start") << "none\n";
    }

    template <int dim>
    void
    tell_sizes(const Scene<dim>           &scene,
               const SceneParameters<dim> &parameters,
               const Counts<dim>          &counts,
               const StepReport           &initial,
               std::ostream               &out)
    {
      const double in_cell = initial.totals.particles / double(counts.cells);
      card_line(out, "particles a cell") << brief(in_cell) << '\n';
      if (in_cell < 1.5)
        out << "  note: with one particle in a cell some motions of the nodes "
               "have neither mass nor strain: "
            << (scene.balance.has(starved_nodes_effect)
                  ? "nodes move as those of cells twice as large"
                  : "Newton takes many iterations, and may stall")
            << ". Take 2 Points per direction\n";
      constexpr double enough = dim == 2 ? 16. : 64.;
      if (in_cell > 1.2 * enough)
        out << "  note: 4 particles in each direction of a cell are enough for "
               "most scenes; half the Points per direction cost 1/"
            << (1 << dim) << " in all that particles do\n";
      // positions and fields as numbers of 4 to 8 bytes, compressed
      const double bytes = 100. * initial.totals.particles *
                           parameters.output.frames *
                           parameters.output.particle_files;
      if (bytes > 1e9)
        out << "  note: particle files will be about " << brief(bytes / 1e9)
            << " GB; fewer Output/Frames or Particle fields are cheaper\n";
    }
  } // namespace

  template <int dim>
  void
  advise(const Scene<dim>           &scene,
         const SceneParameters<dim> &parameters,
         const StepReport           &initial,
         std::ostream               &out)
  {
    if (!parameters.time.is_static())
      {
        tell_waves(scene, initial, out);
        tell_load_waves(scene, parameters, initial, out);
      }
    tell_units(scene, out);
    tell_weights(scene, parameters, out);
    tell_starved(scene, out);
    const auto counts = count(scene);
    tell_walls(scene, counts, out);
    if (counts.overlaps > 0)
      out << "  note: the boxes of " << counts.overlaps
          << " particles reach into another body"
          << (counts.first.empty()
                ? std::string()
                : ", as of <" + counts.first + "> into <" + counts.second + ">")
          << ": there is more mass than room. Leave a gap, or let faces lie on "
             "the cells' lattice\n";
    if (counts.on_faces > 0)
      out << "  note: " << counts.on_faces
          << " particles lie on faces of cells, to 1e-12 of their size: "
             "round-off decides to which cell they belong. Shift the grid or "
             "the body by a part of a cell, or take other Points per "
             "direction\n";
    tell_effect_advice(scene, parameters, out);
    tell_sizes(scene, parameters, counts, initial, out);
    tell_cheaper_settings(scene,
                          parameters,
                          initial,
                          initial.totals.particles / double(counts.cells),
                          out);
  }

  template <int dim>
  void
  calibrate(Scene<dim>                 &scene,
            const SceneParameters<dim> &parameters,
            std::ostream               &out)
  {
    const MPI_Comm      communicator = scene.grid.communicator();
    const dealii::Timer timer;
    const StepReport    report = scene.advance();
    const double        seconds =
      dealii::Utilities::MPI::max(timer.wall_time(), communicator);
    dealii::Utilities::System::MemoryStats memory; // in kB
    dealii::Utilities::System::get_memory_stats(memory);
    const double megabytes =
      dealii::Utilities::MPI::sum(1.024e-3 * memory.VmHWM, communicator);
    double n_steps = std::ceil(parameters.time.end_time / report.time_step);
    if (parameters.time.maximum_steps > 0)
      n_steps = std::min<double>(n_steps, parameters.time.maximum_steps);
    card_line(out, "first step made")
      << brief(seconds) << " s, " << report.newton_iterations
      << " Newton iterations; " << n_steps << " such steps take "
      << brief(n_steps * seconds) << " s\n";
    card_line(out, "")
      << "steps get shorter and need more iterations where bodies "
         "meet or fold; files and pictures come on top\n";
    card_line(out, "memory")
      << brief(megabytes) << " MB by then, on all ranks\n";
  }

  template void
  calibrate<2>(Scene<2> &, const SceneParameters<2> &, std::ostream &);
  template void
  calibrate<3>(Scene<3> &, const SceneParameters<3> &, std::ostream &);
  template void
  advise<2>(const Scene<2> &,
            const SceneParameters<2> &,
            const StepReport &,
            std::ostream &);
  template void
  advise<3>(const Scene<3> &,
            const SceneParameters<3> &,
            const StepReport &,
            std::ostream &);
} // namespace emmy
