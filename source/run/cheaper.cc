#include <emmy/effects/field_load.h>
#include <emmy/run/cheaper.h>
#include <emmy/run/load_waves.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <ostream>

namespace emmy
{
  namespace
  {
    /** A setting, and what it does to time and errors. */
    struct Setting
    {
      bool        fits; ///< the scene could take it
      const char *what, *measured;
    };

    /** The smallest number of cells across a body. */
    template <int dim>
    double
    cells_across(const Scene<dim> &scene)
    {
      const auto h      = scene.grid.size_at(scene.grid.lower_corner());
      const auto size   = scene.grid.upper_corner() - scene.grid.lower_corner();
      double     result = std::numeric_limits<double>::infinity();
      for (const Body<dim> &body : scene.bodies)
        for (unsigned int d = 0; d < dim; ++d)
          result = std::min(result,
                            std::min(body.shape->bounding_box().side_length(d),
                                     size[d]) /
                              h[d]);
      return result;
    }

    /** How far the fastest waves run in a step, in cells. */
    template <int dim>
    double
    courant_number(const Scene<dim> &scene, const double time_step)
    {
      const auto   h      = scene.grid.size_at(scene.grid.lower_corner());
      const double least  = *std::min_element(h.begin_raw(), h.end_raw());
      double       result = 0.;
      for (unsigned int b = 0; b < scene.bodies.size(); ++b)
        result =
          std::max(result,
                   std::sqrt(scene.material_of_body[b]->p_wave_modulus() /
                             scene.bodies[b].density) *
                     time_step / least);
      return result;
    }
  } // namespace

  // The test advice finds the rows of the tables that these figures are from.
  template <int dim>
  void
  tell_cheaper_settings(const Scene<dim>           &scene,
                        const SceneParameters<dim> &parameters,
                        const StepReport           &initial,
                        const double                in_cell,
                        std::ostream               &out)
  {
    const MethodParameters &method      = parameters.method;
    const TimeParameters   &time        = parameters.time;
    const auto             &names       = parameters.effect_names.names;
    const bool              is_implicit = !time.is_explicit();
    const bool              is_dynamic  = is_implicit && !time.is_static();
    // what acts on the outermost particles was measured with GIMP only
    const bool acts_inside = method.least_threshold == 0.;
    const bool is_body_force_alone =
      std::all_of(names.begin(), names.end(), [&](const std::string &name) {
        return dynamic_cast<const UniformAcceleration<dim> *>(
                 parameters.effects.at(name).get()) != nullptr;
      });
    const bool can_be_explicit = is_dynamic && is_body_force_alone &&
                                 acts_inside &&
                                 method.locking_treatment == "none" &&
                                 courant_number(scene, initial.time_step) <= 1.;
    const bool         is_coarse = cells_across(scene) < 16.;
    const unsigned int n_ranks =
      dealii::Utilities::MPI::n_mpi_processes(scene.grid.communicator());
    const Setting settings[] = {
      {is_dynamic && bodies_without_waves(scene, initial.time_step).empty(),
       "steps twice as large",
       "0.5 of the time; errors x 1.5 in a collision, x 4 where only steps "
       "make them"},
      {is_dynamic && dim == 2 && !is_coarse,
       "cells twice as large",
       "0.2 of the time; errors x 2.6"},
      {is_dynamic && dim == 3 && !is_coarse,
       "cells twice as large",
       "0.06 of the time; Taylor bar: errors of the radius x 1.4, of the "
       "length x 6"},
      {is_dynamic && method.is_at_middle(time),
       "Geometry = start",
       "0.5 to 0.8 of the time; errors x 1.5 in a collision, x 19 in "
       "compression that lasts"},
      {is_dynamic && method.shape_functions == "GIMP" && acts_inside,
       "Shape functions = linear",
       "0.3 of the time; errors x 19, and finer grids do not help once "
       "particles cross cells"},
      {in_cell > 0.9 * std::pow(4., dim),
       "Points per direction",
       "4 to 2: 0.85 of the time; errors x 2.5"},
      {is_implicit && parameters.solver.newton_tolerance <= 1e-8,
       "Newton tolerance = 1e-2",
       "0.65 of the time; errors of 2e-5 of the radius of a Taylor bar; the "
       "ledger says what is left"},
      {can_be_explicit,
       "Integrator = explicit",
       "0.05 to 0.15 of the time; errors x 7 to 13, by its lumped mass"},
      {n_ranks == 1 && initial.totals.particles > 5000,
       "mpirun -np 2",
       "0.7 of the time; the same results"}};
    out << "  cheaper settings      measured in other scenes "
           "(doc/accuracy-and-cost.md, doc/performance.md):\n";
    for (const Setting &setting : settings)
      if (setting.fits)
        out << std::string(24, ' ') << std::left << std::setw(26)
            << setting.what << setting.measured << '\n';
  }

  template void
  tell_cheaper_settings<2>(const Scene<2> &,
                           const SceneParameters<2> &,
                           const StepReport &,
                           const double,
                           std::ostream &);
  template void
  tell_cheaper_settings<3>(const Scene<3> &,
                           const SceneParameters<3> &,
                           const StepReport &,
                           const double,
                           std::ostream &);
} // namespace emmy
