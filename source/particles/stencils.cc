#include <emmy/particles/stencils.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  LinearShapeFunctions<dim>::LinearShapeFunctions(
    const unsigned int body_component)
    : body_component(body_component)
  {}

  template <int dim>
  EffectCard
  LinearShapeFunctions<dim>::card()
  {
    EffectCard card;
    card.enters = "stencils: the nodes of the particle's cell";
    card.phases = {"stencils"};
    return card;
  }

  template <int dim>
  Stencils<dim>
  LinearShapeFunctions<dim>::evaluate(
    const dealii::Particles::ParticleHandler<dim> &particles,
    const BackgroundGrid<dim>                     &grid) const
  {
    constexpr unsigned int n_nodes = BackgroundGrid<dim>::nodes_per_cell;
    const std::size_t      n       = particles.n_locally_owned_particles();
    const auto            &h       = grid.cell_size();

    Stencils<dim> stencils;
    stencils.particles.reserve(n);
    stencils.values.resize(n * n_nodes);
    stencils.gradients.resize(n * n_nodes * dim);

    const auto body_of = [this](const auto &particle) {
      return static_cast<unsigned int>(
        particle->get_properties()[body_component]);
    };

    // The particles of a cell stand together. Neither the order of cells nor
    // that within one may depend on which part of the grid has cells.
    struct Filled
    {
      typename BackgroundGrid<dim>::Lattice    place;
      typename Stencils<dim>::ParticleIterator first;
      unsigned int                             n_particles;
    };
    std::vector<Filled> filled;
    for (auto particle = particles.begin(); particle != particles.end();)
      {
        const auto cell = particle->get_surrounding_cell();
        filled.push_back({grid.lattice(cell), particle, 0});
        for (; particle != particles.end() &&
               particle->get_surrounding_cell() == cell;
             ++particle)
          ++filled.back().n_particles;
      }
    std::sort(filled.begin(), filled.end(), [](const auto &a, const auto &b) {
      return a.place < b.place;
    });

    for (const Filled &run : filled)
      {
        const auto cell = run.first->get_surrounding_cell();
        stencils.active_cells.push_back(cell);
        const auto ids      = grid.node_ids(cell);
        const auto lower    = grid.corner(run.place);
        const auto first    = stencils.particles.size();
        auto       particle = run.first;
        for (unsigned int i = 0; i < run.n_particles; ++i)
          stencils.particles.push_back(particle++);
        // most often they are in order already
        const auto is_before = [&](const auto &a, const auto &b) {
          return std::make_pair(body_of(a), a->get_id()) <
                 std::make_pair(body_of(b), b->get_id());
        };
        if (!std::is_sorted(stencils.particles.begin() + first,
                            stencils.particles.end(),
                            is_before))
          std::sort(stencils.particles.begin() + first,
                    stencils.particles.end(),
                    is_before);

        for (auto p = first; p < stencils.particles.size();)
          {
            typename Stencils<dim>::Group group;
            group.first_point = p;
            group.body        = body_of(stencils.particles[p]);
            while (p < stencils.particles.size() &&
                   body_of(stencils.particles[p]) == group.body)
              ++p;
            group.n_points    = p - group.first_point;
            group.n_nodes     = n_nodes;
            group.first_node  = stencils.node_ids.size();
            group.first_value = group.first_point * n_nodes;
            stencils.node_ids.insert(stencils.node_ids.end(),
                                     ids.begin(),
                                     ids.end());

            for (unsigned int q = 0; q < group.n_points; ++q)
              {
                // per direction: the hats of both nodes and their slopes
                const auto &x =
                  stencils.particles[group.first_point + q]->get_location();
                std::array<std::array<double, 2>, dim> hat;
                for (unsigned int d = 0; d < dim; ++d)
                  {
                    const double xi = (x[d] - lower[d]) / h[d];
                    hat[d]          = {{1. - xi, xi}};
                  }
                for (unsigned int a = 0; a < n_nodes; ++a)
                  {
                    const auto side = [a](const unsigned int d) {
                      return (a >> d) & 1;
                    };
                    double value = 1.;
                    for (unsigned int d = 0; d < dim; ++d)
                      value *= hat[d][side(d)];
                    stencils
                      .values[group.first_value + a * group.n_points + q] =
                      value;
                    for (unsigned int d = 0; d < dim; ++d)
                      {
                        double slope = (side(d) ? 1. : -1.) / h[d];
                        for (unsigned int e = 0; e < dim; ++e)
                          if (e != d)
                            slope *= hat[e][side(e)];
                        stencils.gradients[dim * group.first_value +
                                           (a * dim + d) * group.n_points + q] =
                          slope;
                      }
                  }
              }
            stencils.groups.push_back(group);
          }
      }
    return stencils;
  }

  template class LinearShapeFunctions<2>;
  template class LinearShapeFunctions<3>;
} // namespace emmy
