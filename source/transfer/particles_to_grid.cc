#include <emmy/particles/with_n_points.h>
#include <emmy/transfer/mass_blocks.h>

namespace emmy
{
  namespace
  {
    template <int dim>
    void
    gather_in_order(
      const std::vector<dealii::Particles::ParticleIterator<dim>> &particles,
      const FieldLayout                                           &layout,
      PointArrays<dim>                                            &points)
    {
      const unsigned int n_components = layout.n_components();
      if (points.n_points() != particles.size())
        points = PointArrays<dim>(particles.size(), n_components);
      for (std::size_t p = 0; p < points.n_points(); ++p)
        {
          const auto &particle   = *particles[p];
          const auto  properties = particle.get_properties();
          for (unsigned int d = 0; d < dim; ++d)
            points.position(d)[p] = particle.get_location()[d];
          for (unsigned int c = 0; c < n_components; ++c)
            points.component(c)[p] = properties[c];
        }
    }
  } // namespace

  template <int dim>
  PointArrays<dim>
  gather(const Stencils<dim> &stencils, const FieldLayout &layout)
  {
    PointArrays<dim> points;
    gather(stencils, layout, points);
    return points;
  }

  template <int dim>
  void
  gather(const Stencils<dim> &stencils,
         const FieldLayout   &layout,
         PointArrays<dim>    &points)
  {
    gather_in_order<dim>(stencils.particles, layout, points);
  }

  template <int dim>
  PointArrays<dim>
  gather(const Places<dim> &places, const FieldLayout &layout)
  {
    PointArrays<dim> points;
    gather_in_order<dim>(places.particles, layout, points);
    return points;
  }

  template <int dim>
  std::vector<double>
  lumped_mass(const GridStart<dim> &start)
  {
    const unsigned int  n = start.active->n_local_nodes();
    std::vector<double> sums(dim * n), result(n);
    start.mass.add_times(std::vector<double>(dim * n, 1.), sums);
    for (unsigned int node = 0; node < n; ++node)
      result[node] = sums[unknown<dim>(node, 0)];
    start.active->share(result);
    return result;
  }

  template <int dim>
  Matrix
  mass_of_unknowns(const GridStart<dim>                       &start,
                   const typename NodalMatrix<dim>::Conditions conditions,
                   const Damped                                damped)
  {
    Matrix result;
    start.active->graph().reinit(result);
    start.mass.add_to(result,
                      1.,
                      conditions,
                      damped == Damped::yes ? start.damping
                                            : std::vector<double>());
    start.active->graph().finish(result);
    return result;
  }

  template <int dim>
  ParticlesToGrid<dim>::ParticlesToGrid(
    const BackgroundGrid<dim>     &grid,
    const BoundaryConditions<dim> &boundary_conditions,
    const FieldLayout             &layout,
    const PointMapping            &mapping,
    Phases                        *phases)
    : grid(grid)
    , boundary_conditions(boundary_conditions)
    , phases(phases)
    , mass_component(layout["mass"])
    , velocity_component(layout["velocity"])
  {
    start.lumping = mapping.lumping;
  }

  template <int dim>
  GridStart<dim> &
  ParticlesToGrid<dim>::renew_but_for_mass(const Stencils<dim>    &stencils,
                                           const PointArrays<dim> &points,
                                           const Couplings<dim>   &couplings)
  {
    start.hand_out_mass = couplings.hand_out_mass;
    if (!start.active || !start.active->fits(stencils, couplings))
      {
        start.mass   = {}; // it holds the grid before
        start.active = std::make_shared<const ActiveGrid<dim>>(
          stencils,
          couplings,
          grid,
          boundary_conditions,
          ActiveGrid<dim>::Matrices::wanted,
          start.active.get());
        start.momentum      = start.active->make_vector();
        start.mean_velocity = start.active->make_vector();
      }
    assemble_momentum(stencils, points);
    return start;
  }

  template <int dim>
  GridStart<dim> &
  ParticlesToGrid<dim>::renew_momentum(const Stencils<dim>    &stencils,
                                       const PointArrays<dim> &points)
  {
    assemble_momentum(stencils, points);
    return start;
  }

  template <int dim>
  GridStart<dim> &
  ParticlesToGrid<dim>::operator()(const Stencils<dim>    &stencils,
                                   const PointArrays<dim> &points,
                                   const Couplings<dim>   &couplings)
  {
    renew_but_for_mass(stencils, points, couplings);
    assemble_mass(stencils, points);
    return start;
  }

  template <int dim>
  void
  ParticlesToGrid<dim>::assemble_mass(const Stencils<dim>    &stencils,
                                      const PointArrays<dim> &points)
  {
    start.mass.reinit(start.active);
    start.damping.assign(start.active->n_local_nodes(), 0.);
    const auto add_block = [&](MassBlock &block) {
      start.mass.add(block.nodes, block.mass);
      for (unsigned int a = 0; a < block.mass.m(); ++a)
        start.damping[block.nodes[a]] += block.damping[a];
    };
    for_each_mass_block<dim>(
      stencils, points.component(mass_component), start, phases, add_block);
  }

  template <int dim>
  void
  ParticlesToGrid<dim>::assemble_momentum(const Stencils<dim>    &stencils,
                                          const PointArrays<dim> &points)
  {
    const ActiveGrid<dim> &active = *start.active;
    const double          *mass   = points.component(mass_component);
    // a node on whose far side a particle lies exactly has S = 0, but a mean
    constexpr double    least_weight = 1e-12;
    const unsigned int  n_local      = dim * active.n_local_nodes();
    std::vector<double> momentum(n_local), weighted_velocity(n_local),
      weights(n_local);
    std::vector<double> own_momentum; // of the points of a group, by component
    for (const auto &group : stencils.groups)
      with_n_points(group.n_points, [&](const auto n_points) {
        const unsigned int n = n_points;
        const double      *m = mass + group.first_point;
        own_momentum.resize(dim * n);
        double                  total = 0.;
        std::array<double, dim> total_momentum{};
        for (unsigned int p = 0; p < n; ++p)
          total += m[p];
        for (unsigned int c = 0; c < dim; ++c)
          {
            const double *v =
              points.component(velocity_component + c) + group.first_point;
            for (unsigned int p = 0; p < n; ++p)
              total_momentum[c] += own_momentum[c * n + p] = m[p] * v[p];
          }
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          {
            const double *S      = stencils.value(group, a);
            double        of_one = 0.;
            for (unsigned int p = 0; p < n; ++p)
              of_one += S[p] * m[p];
            for (unsigned int c = 0; c < dim; ++c)
              {
                const unsigned int i = unknown<dim>(active.nodes(group)[a], c);
                double             sum = 0.;
                for (unsigned int p = 0; p < n; ++p)
                  sum += S[p] * own_momentum[c * n + p];
                momentum[i] += sum;
                weighted_velocity[i] += sum + least_weight * total_momentum[c];
                weights[i] += of_one + least_weight * total;
              }
          }
      });
    start.momentum = 0.;
    active.add(momentum, start.momentum);

    Vector total_weight = active.make_vector();
    active.add(weights, total_weight);
    start.mean_velocity = 0.;
    active.add(weighted_velocity, start.mean_velocity);
    auto weight = total_weight.begin();
    for (double &v : start.mean_velocity)
      v /= *weight++;
  }

  template PointArrays<2>
  gather<2>(const Stencils<2> &, const FieldLayout &);
  template PointArrays<3>
  gather<3>(const Stencils<3> &, const FieldLayout &);
  template void
  gather<2>(const Stencils<2> &, const FieldLayout &, PointArrays<2> &);
  template PointArrays<2>
  gather<2>(const Places<2> &, const FieldLayout &);
  template void
  gather<3>(const Stencils<3> &, const FieldLayout &, PointArrays<3> &);
  template PointArrays<3>
  gather<3>(const Places<3> &, const FieldLayout &);
  template std::vector<double>
  lumped_mass<2>(const GridStart<2> &);
  template std::vector<double>
  lumped_mass<3>(const GridStart<3> &);
  template Matrix
  mass_of_unknowns<2>(const GridStart<2> &,
                      const NodalMatrix<2>::Conditions,
                      const Damped);
  template Matrix
  mass_of_unknowns<3>(const GridStart<3> &,
                      const NodalMatrix<3>::Conditions,
                      const Damped);
  template class ParticlesToGrid<2>;
  template class ParticlesToGrid<3>;
} // namespace emmy
