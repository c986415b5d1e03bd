#include <emmy/transfer/middle_places.h>
#include <emmy/transfer/particle_sort.h>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    Field
    velocity_field()
    {
      return {"grid_velocity",
              Field::Kind::vector,
              "m/s",
              "velocity of the grid at the particle at the end of the step; "
              "the next one looks for its middle there"};
    }

    Field
    velocity_gradient_field()
    {
      return {"grid_velocity_gradient",
              Field::Kind::tensor,
              "1/s",
              "gradient of that velocity"};
    }
  } // namespace

  template <int dim>
  EffectCard
  middle_card(const bool is_present)
  {
    EffectCard card;
    card.name    = middle_effect;
    card.setting = "Method/Geometry = middle";
    card.enters  = "all of a step: Newton looks for its places too, and each "
                   "iteration has stencils and a mass of its own";
    card.fields  = {velocity_field(), velocity_gradient_field()};
    for (const char *axis : {"x", "y", "z"})
      if (dim == 3 || *axis == 'z')
        card.ledger_columns.push_back(std::string("angular_momentum_left_") +
                                      axis);
    card.ledger_columns.push_back("place_defect");
    card.is_present = is_present;
    return card;
  }

  template <int dim>
  MiddlePlaces<dim>::MiddlePlaces(FieldLayout &layout)
    : grid_velocity(layout.add(velocity_field()))
    , grid_velocity_gradient(layout.add(velocity_gradient_field()))
  {}

  template <int dim>
  void
  MiddlePlaces<dim>::begin(
    const FieldLayout                       &layout,
    dealii::Particles::ParticleHandler<dim> &particles) const
  {
    const unsigned int velocity = layout["velocity"];
    for (auto &particle : particles)
      for (unsigned int c = 0; c < dim; ++c)
        particle.get_properties()[grid_velocity + c] =
          particle.get_properties()[velocity + c];
  }

  template <int dim>
  void
  MiddlePlaces<dim>::hand_over(
    const double                             time_step,
    BackgroundGrid<dim>                     &grid,
    dealii::Particles::ParticleHandler<dim> &particles) const
  {
    sort_into_cells<dim>(grid, particles, [&](const auto &particle) {
      dealii::Point<dim> x = particle.get_location();
      for (unsigned int c = 0; c < dim; ++c)
        x[c] += 0.5 * time_step * particle.get_properties()[grid_velocity + c];
      return x;
    });
  }

  template <int dim>
  Places<dim>
  MiddlePlaces<dim>::first(Places<dim>                places,
                           const PointArrays<dim>    &states,
                           const double               time_step,
                           const DomainUpdate<dim>   *update,
                           const BackgroundGrid<dim> &grid) const
  {
    for (std::size_t p = 0; p < places.size(); ++p)
      {
        dealii::Point<dim> x = states.point(p);
        x += 0.5 * time_step * states.template get<dim>(grid_velocity, p);
        places.positions[p] = grid.clamped(x);
        places.cells[p]     = grid.key_of(places.positions[p]);
        if (places.half_lengths.empty() || !update)
          continue;
        Tensor<2, dim> Z;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            Z[i][j] =
              (i == j ? 1. : 0.) -
              0.5 * time_step *
                states.component(grid_velocity_gradient + dim * i + j)[p];
        if (determinant(Z) > 0.) // else the size at t must do
          places.half_lengths[p] =
            update->middle(states, p, places.bodies[p], invert(Z)).half_length;
      }
    return places;
  }

  template <int dim>
  void
  MiddlePlaces<dim>::leave(const Stencils<dim>       &stencils,
                           const ActiveGrid<dim>     &active,
                           const std::vector<double> &velocity,
                           PointArrays<dim>          &trial) const
  {
    for (const auto &group : stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const unsigned int *nodes = active.nodes(group);
          const std::size_t   p     = group.first_point + q;
          Tensor<1, dim>      w;
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            for (unsigned int c = 0; c < dim; ++c)
              w[c] += stencils.value(group, a)[q] *
                      velocity[unknown<dim>(nodes[a], c)];
          trial.set(grid_velocity, p, w);
          const Tensor<2, dim> L =
            stencils.displacement_gradient(group, q, nodes, velocity);
          for (unsigned int i = 0; i < dim; ++i)
            for (unsigned int j = 0; j < dim; ++j)
              trial.component(grid_velocity_gradient + dim * i + j)[p] =
                L[i][j];
        }
  }

  template EffectCard
  middle_card<2>(const bool);
  template EffectCard
  middle_card<3>(const bool);
  template class MiddlePlaces<2>;
  template class MiddlePlaces<3>;
} // namespace emmy
