#ifndef emmy_tests_step_cloud_h
#define emmy_tests_step_cloud_h

#include <emmy/effects/ghost_stabilisation.h>
#include <emmy/effects/gravity.h>
#include <emmy/effects/inertia.h>
#include <emmy/effects/internal_force.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/effects/moving_walls.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/effects/wall_mapping.h>
#include <emmy/material/hencky.h>
#include <emmy/material/von_mises.h>
#include <emmy/particles/gimp.h>
#include <emmy/step/stepper.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

namespace emmy
{
  namespace test
  {
    /** Of a number or tensor. */
    template <typename Value>
    Value
    sum_over_ranks(const Value &value)
    {
      return dealii::Utilities::MPI::sum(value, MPI_COMM_WORLD);
    }

    /** What a test asks of a random cloud of particles. */
    struct CloudOptions
    {
      unsigned int             n_points     = 60;
      unsigned int             seed         = 1;
      bool                     gravity      = false;
      std::vector<std::string> roller       = {}; ///< sides of the grid
      std::vector<std::string> fixed        = {};
      double                   stiffness    = 1e3; ///< Young's modulus, Pa
      bool                     gimp         = false;
      bool                     plastic      = false;
      bool                     treated      = false; ///< mean dilatation
      bool                     moving       = false; ///< the side y-min
      std::string              wall_mapping = "constrained";
      double ghost_mass = 0., ghost_stiffness = 0.; ///< penalties
      double aggregation = 0.;                      ///< mass threshold; 0: none
      double width = 1.; ///< of the grid in x, from below, that has points
    };

    /**
     * Particles of random position, velocity, mass and strain on a grid of
     * 4 x 3 (x 3) cells, and all that advances them.
     */
    template <int dim>
    struct Cloud
    {
      std::unique_ptr<GridParameters<dim>>     grid_parameters;
      std::unique_ptr<BoundaryParameters>      boundary_parameters;
      std::unique_ptr<MovingWallParameters>    moving_walls;
      std::unique_ptr<SolverParameters>        solver_parameters;
      std::unique_ptr<BackgroundGrid<dim>>     grid;
      std::unique_ptr<BoundaryConditions<dim>> boundary_conditions;
      std::unique_ptr<Material<dim>>           material;
      FieldLayout                              layout = basic_fields(dim);
      std::unique_ptr<Balance<dim>>            balance;
      std::unique_ptr<ShapeFunctions<dim>>     shape_functions;
      dealii::Particles::ParticleHandler<dim>  particles;
      dealii::Tensor<1, dim>                   acceleration;

      explicit Cloud(const CloudOptions &options,
                     const MPI_Comm      communicator = MPI_COMM_WORLD)
      {
        dealii::ParameterAcceptor::clear();
        grid_parameters     = std::make_unique<GridParameters<dim>>();
        boundary_parameters = std::make_unique<BoundaryParameters>();
        moving_walls        = std::make_unique<MovingWallParameters>(dim);
        solver_parameters   = std::make_unique<SolverParameters>();

        // not a cube, not at the origin
        grid_parameters->cells    = std::vector<unsigned int>(dim, 3);
        grid_parameters->cells[0] = 4;
        for (unsigned int d = 0; d < dim; ++d)
          {
            grid_parameters->lower_corner[d] = -0.3 + d;
            grid_parameters->upper_corner[d] = 1.7 + 1.3 * d;
          }
        grid =
          std::make_unique<BackgroundGrid<dim>>(*grid_parameters, communicator);
        boundary_parameters->roller = options.roller;
        boundary_parameters->fixed  = options.fixed;
        if (options.moving)
          moving_walls->velocities[2] =
            dim == 2 ? "0.4 + t; -0.3" : "0.4 + t; -0.3; 0.2";
        boundary_conditions =
          std::make_unique<BoundaryConditions<dim>>(*boundary_parameters,
                                                    *grid);

        ElasticConstants constants;
        constants.density       = 10.;
        constants.young_modulus = options.stiffness;
        constants.poisson_ratio = 0.3;
        constants               = constants.completed("test");
        if (options.plastic)
          material = std::make_unique<VonMises<dim>>(
            constants,
            YieldSurface{0.05 * options.stiffness, 0.1 * options.stiffness});
        else
          material = std::make_unique<Hencky<dim>>(constants);

        Effects<dim> effects;
        effects.terms.push_back(std::make_unique<Inertia<dim>>(layout["mass"]));
        const std::vector<const Material<dim> *> materials{material.get()};
        if (options.treated)
          effects.terms.push_back(std::make_unique<MeanDilatation<dim>>(
            materials, layout, MeanDilatation<dim>::Kind::conserving));
        else
          effects.terms.push_back(
            std::make_unique<InternalForce<dim>>(materials, layout));
        if (options.moving)
          effects.terms.push_back(std::make_unique<MovingWalls<dim>>(
            *moving_walls, *boundary_conditions, *grid));
        if (options.wall_mapping != "constrained")
          effects.terms.push_back(
            std::make_unique<WallMapping<dim>>(options.wall_mapping));
        if (options.gravity)
          {
            for (unsigned int d = 0; d < dim; ++d)
              acceleration[d] = -3. + d;
            effects.terms.push_back(
              std::make_unique<Gravity<dim>>(acceleration, layout["mass"]));
          }
        if (options.ghost_mass > 0. || options.ghost_stiffness > 0.)
          effects.terms.push_back(std::make_unique<GhostStabilisation<dim>>(
            GhostFaces<dim>(options.ghost_mass,
                            options.ghost_stiffness,
                            std::vector<const Material<dim> *>{
                              material.get()})));
        if (options.aggregation > 0.)
          effects.terms.push_back(std::make_unique<StarvedNodes<dim>>(
            Aggregation<dim>(options.aggregation,
                             layout["mass"],
                             layout["reference_volume"])));
        balance = std::make_unique<Balance<dim>>(std::move(effects));
        if (options.gimp)
          shape_functions = std::make_unique<GimpShapeFunctions<dim>>(layout);
        else
          shape_functions =
            std::make_unique<LinearShapeFunctions<dim>>(layout["body"]);

        particles.initialize(grid->triangulation(),
                             grid->mapping(),
                             layout.n_components());
        add_points(options);
      }

      /** Random points, the same on any number of ranks. */
      void
      add_points(const CloudOptions &options)
      {
        std::mt19937                           generator(options.seed);
        std::uniform_real_distribution<double> unit(0., 1.);
        const auto                             random = [&](const double size) {
          return size * (2. * unit(generator) - 1.);
        };
        for (unsigned int id = 0; id < options.n_points; ++id)
          {
            dealii::Point<dim> x;
            for (unsigned int d = 0; d < dim; ++d)
              {
                const double margin = 0.1 * grid->cell_size()[d];
                const double length =
                  (d == 0 ? options.width : 1.) *
                  (grid->upper_corner()[d] - grid->lower_corner()[d]);
                x[d] = grid->lower_corner()[d] + margin +
                       unit(generator) * (length - 2. * margin);
              }
            std::vector<double> values = layout.initial_values();
            for (unsigned int d = 0; d < dim; ++d)
              values[layout["velocity"] + d] =
                0.5 + 0.4 * x[(d + 1) % dim] + random(0.2);
            values[layout["mass"]]             = 0.5 + unit(generator);
            values[layout["reference_volume"]] = 0.02 + 0.01 * unit(generator);
            if (options.aggregation > 0.) // starved is what has few points
              {
                double volume = 1.2 - 0.4 * unit(generator);
                for (unsigned int d = 0; d < dim; ++d)
                  volume *= grid->upper_corner()[d] - grid->lower_corner()[d];
                volume /= options.n_points;
                values[layout["mass"]]             = 10. * volume;
                values[layout["reference_volume"]] = volume;
              }

            dealii::Tensor<2, dim> F;
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int j = 0; j < dim; ++j)
                F[i][j] = (i == j) + random(0.15);
            set_state(F, 1. + random(0.05), values);
            if (layout.has("half_length"))
              for (unsigned int d = 0; d < dim; ++d)
                values[layout["half_length"] + d] =
                  (0.1 + 0.4 * unit(generator)) * grid->cell_size()[d];
            if (layout.has(own_volume_field)) // not that of the stress
              values[layout[own_volume_field]] = random(0.2);
            insert(id, x, values);
          }
        particles.update_cached_numbers();
      }

      /** The state of a particle that was deformed by F. */
      void
      set_state(const dealii::Tensor<2, dim> &F,
                const double                  b33,
                std::vector<double>          &values) const
      {
        const auto b = mandel::symmetric_part<dim>(F * transpose(F), b33) -
                       mandel::unit<dim>();
        MaterialBatch<dim> state;
        state.n_points                       = 1;
        state.left_cauchy_green_less_unit[0] = b;
        state.history.resize(material->history().size());
        for (auto &history : state.history)
          history[0] = 0.;
        material->evaluate(state);
        const auto set = [&](const char *name, const auto &tensor) {
          for (unsigned int c = 0; c < n_mandel<dim>; ++c)
            values[layout[name] + c] = tensor[c];
        };
        set("left_cauchy_green_less_unit", b);
        set("kirchhoff_stress", state.kirchhoff_stress[0]);
        values[layout["strain_energy_density"]] = state.stored_energy[0];
        if (state.history.empty())
          return;
        set("elastic_left_cauchy_green_less_unit",
            state.left_cauchy_green_less_unit[0]);
        values[layout["equivalent_plastic_strain"]] = state.history[0][0];
        values[layout["hardening_energy_density"]]  = state.hardening_energy[0];
        values[layout["plastic_dissipation_density"]] = state.dissipation[0];
      }

      /** Insert a particle on the rank that owns its cell. */
      void
      insert(const unsigned int         id,
             const dealii::Point<dim>  &x,
             const std::vector<double> &values)
      {
        for (const auto &cell : grid->triangulation().active_cell_iterators())
          if (cell->is_locally_owned())
            {
              dealii::Point<dim> reference;
              bool               is_inside = true;
              for (unsigned int d = 0; d < dim; ++d)
                {
                  reference[d] =
                    (x[d] - cell->vertex(0)[d]) / grid->cell_size()[d];
                  is_inside =
                    is_inside && reference[d] >= 0. && reference[d] < 1.;
                }
              if (is_inside)
                particles.insert_particle(x,
                                          reference,
                                          id,
                                          cell,
                                          dealii::ArrayView<const double>(
                                            values.data(), values.size()));
            }
      }
    };
  } // namespace test
} // namespace emmy

#endif
