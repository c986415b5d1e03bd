#include <deal.II/base/patterns.h>

#include <emmy/base/exceptions.h>
#include <emmy/particles/gimp.h>

#include <algorithm>
#include <map>

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
  Places<dim>
  LinearShapeFunctions<dim>::places(
    const dealii::Particles::ParticleHandler<dim> &particles,
    const BackgroundGrid<dim>                     &grid) const
  {
    return places_now(particles, grid, body_component);
  }

  template <int dim>
  Places<dim>
  places_now(const dealii::Particles::ParticleHandler<dim> &particles,
             const BackgroundGrid<dim>                     &grid,
             const unsigned int                             body_component)
  {
    Places<dim>       places;
    const std::size_t n = particles.n_locally_owned_particles();
    places.particles.reserve(n);
    places.bodies.reserve(n);
    places.cells.reserve(n);
    places.positions.reserve(n);
    for (auto particle = particles.begin(); particle != particles.end();)
      {
        const auto cell    = particle->get_surrounding_cell();
        const auto lattice = grid.key_of(cell);
        for (; particle != particles.end() &&
               particle->get_surrounding_cell() == cell;
             ++particle)
          {
            places.particles.push_back(particle);
            places.bodies.push_back(static_cast<unsigned int>(
              particle->get_properties()[body_component]));
            places.cells.push_back(lattice);
            places.positions.push_back(particle->get_location());
          }
      }
    return places;
  }

  namespace
  {
    /**
     * The order of points: by cell, then by body, then by id. Neither the
     * order of cells nor that within one may depend on which part of the grid
     * has cells.
     */
    template <int dim>
    std::vector<std::size_t>
    order_by_cells(const Places<dim> &places)
    {
      // of points of one cell
      std::vector<std::pair<unsigned int, dealii::types::particle_index>> keys;
      keys.reserve(places.size());
      for (std::size_t i = 0; i < places.size(); ++i)
        keys.emplace_back(places.bodies[i], places.particles[i]->get_id());
      const auto is_before = [&](const std::size_t i, const std::size_t j) {
        return keys[i] < keys[j];
      };
      // particles of a cell stand together already: sort their runs first
      std::vector<std::pair<std::size_t, std::size_t>> runs;
      for (std::size_t i = 0; i < places.size(); ++i)
        if (i > 0 && places.cells[i] == places.cells[i - 1])
          ++runs.back().second;
        else
          runs.emplace_back(i, i + 1);
      std::sort(runs.begin(), runs.end(), [&](const auto &a, const auto &b) {
        return std::make_pair(places.cells[a.first], a.first) <
               std::make_pair(places.cells[b.first], b.first);
      });
      std::vector<std::size_t> order;
      order.reserve(places.size());
      for (const auto &[begin, end] : runs)
        for (std::size_t i = begin; i < end; ++i)
          order.push_back(i);
      for (auto first = order.begin(); first != order.end();)
        {
          auto last = first;
          while (last != order.end() &&
                 places.cells[*last] == places.cells[*first])
            ++last;
          // most often they are in order already
          if (!std::is_sorted(first, last, is_before))
            std::sort(first, last, is_before);
          first = last;
        }
      return order;
    }
  } // namespace

  template <int dim>
  Stencils<dim>
  LinearShapeFunctions<dim>::evaluate(const Places<dim>         &places,
                                      const BackgroundGrid<dim> &grid) const
  {
    constexpr unsigned int n_nodes = BackgroundGrid<dim>::nodes_per_cell;

    Stencils<dim> stencils;
    stencils.order      = order_by_cells(places);
    const std::size_t n = places.size();
    stencils.particles.reserve(n);
    for (const std::size_t i : stencils.order)
      stencils.particles.push_back(places.particles[i]);
    stencils.values.resize(n * n_nodes);
    stencils.gradients.resize(n * n_nodes * dim);

    std::optional<std::size_t>   unknown;
    std::vector<ActiveCell<dim>> found;
    for (std::size_t first = 0, last = 0; first < n; first = last)
      {
        const auto &place = places.cells[stencils.order[first]];
        const auto  body  = places.bodies[stencils.order[first]];
        while (last < n && places.cells[stencils.order[last]] == place &&
               places.bodies[stencils.order[last]] == body)
          ++last;
        const auto cell = grid.cell_at(place);
        if (cell == grid.triangulation().end())
          {
            unknown = stencils.order[first];
            break;
          }
        const unsigned int    field = grid.fields().of_body(body);
        const ActiveCell<dim> active{cell, field};
        if (found.empty() || !(found.back() == active))
          found.push_back(active);
        const auto                    ids = grid.node_ids(cell, field);
        typename Stencils<dim>::Group group;
        group.first_point = first;
        group.n_points    = last - first;
        group.body        = body;
        group.n_nodes     = n_nodes;
        group.first_node  = stencils.node_ids.size();
        group.first_value = first * n_nodes;
        group.n_along.fill(2);
        group.origin = grid.corner(place);
        stencils.node_ids.insert(stencils.node_ids.end(),
                                 ids.begin(),
                                 ids.end());
        add_weights(places, group, grid.size_of(place), stencils);
        stencils.groups.push_back(group);
      }
    stop_at_unknown_cell(places, unknown, grid);
    stencils.active_cells = owned_among_active<dim>(found, grid);
    return stencils;
  }

  template <int dim>
  void
  LinearShapeFunctions<dim>::add_weights(
    const Places<dim>                   &places,
    const typename Stencils<dim>::Group &group,
    const dealii::Tensor<1, dim>        &h,
    Stencils<dim>                       &stencils)
  {
    for (unsigned int q = 0; q < group.n_points; ++q)
      {
        // per direction: the hats of both nodes and their slopes
        const auto &x = places.positions[stencils.order[group.first_point + q]];
        std::array<std::array<double, 2>, dim> hat;
        for (unsigned int d = 0; d < dim; ++d)
          {
            const double xi = (x[d] - group.origin[d]) / h[d];
            hat[d]          = {{1. - xi, xi}};
          }
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          {
            const auto side = [a](const unsigned int d) {
              return (a >> d) & 1;
            };
            double value = 1.;
            for (unsigned int d = 0; d < dim; ++d)
              value *= hat[d][side(d)];
            stencils.values[group.first_value + a * group.n_points + q] = value;
            for (unsigned int d = 0; d < dim; ++d)
              {
                double slope = (side(d) ? 1. : -1.) / h[d];
                for (unsigned int e = 0; e < dim; ++e)
                  if (e != d)
                    slope *= hat[e][side(e)];
                stencils.gradients[dim * group.first_value +
                                   (a * dim + d) * group.n_points + q] = slope;
              }
          }
      }
  }

  template <int dim>
  void
  LinearShapeFunctions<dim>::differentiate(
    const Places<dim>                   &places,
    const std::size_t                    i,
    const typename Stencils<dim>::Group &group,
    const BackgroundGrid<dim>           &grid,
    PlaceDerivatives<dim>               &result) const
  {
    Factors<dim> factors;
    for (unsigned int d = 0; d < dim; ++d)
      {
        const double h  = grid.size_of(places.cells[i])[d];
        const double xi = (places.positions[i][d] - group.origin[d]) / h;
        factors[d][0]   = {1. - xi, -1. / h, -1. / h, 0., 0., 0.};
        factors[d][1]   = {xi, 1. / h, 1. / h, 0., 0., 0.};
      }
    result.combine(factors, group.n_along);
  }

  template <int dim>
  void
  stop_at_unknown_cell(const Places<dim>               &places,
                       const std::optional<std::size_t> index,
                       const BackgroundGrid<dim>       &grid)
  {
    throw_together(
      grid.communicator(),
      "Shape functions",
      index ? "particle " + std::to_string(places.particles[*index]->get_id()) +
                " at (" +
                dealii::Patterns::Tools::to_string(places.positions[*index]) +
                ") m reaches a cell that its rank does not know"
            : std::string(),
      "it moved too far within a step. Take smaller steps "
      "(Time/Factor or Step size), or limit Time/Maximum travel.");
  }

  template <int dim>
  std::vector<ActiveCell<dim>>
  owned_among_active(const std::vector<ActiveCell<dim>> &found,
                     const BackgroundGrid<dim>          &grid)
  {
    using Place = std::pair<CellKey<dim>, unsigned int>;
    std::vector<Place>                         places;
    std::map<unsigned int, std::vector<Place>> of_others;
    for (const auto &[cell, field] : found)
      if (cell->is_locally_owned())
        places.emplace_back(grid.key_of(cell), field);
      else
        of_others[cell->subdomain_id()].emplace_back(grid.key_of(cell), field);
    if (dealii::Utilities::MPI::n_mpi_processes(grid.communicator()) > 1)
      for (const auto &[sender, lattices] :
           dealii::Utilities::MPI::some_to_some(grid.communicator(), of_others))
        {
          (void)sender;
          places.insert(places.end(), lattices.begin(), lattices.end());
        }
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    std::vector<ActiveCell<dim>> owned;
    for (const auto &[place, field] : places)
      owned.push_back({grid.cell_at(place), field});
    return owned;
  }

  template Places<2>
  places_now<2>(const dealii::Particles::ParticleHandler<2> &,
                const BackgroundGrid<2> &,
                const unsigned int);
  template Places<3>
  places_now<3>(const dealii::Particles::ParticleHandler<3> &,
                const BackgroundGrid<3> &,
                const unsigned int);
  template class LinearShapeFunctions<2>;
  template class LinearShapeFunctions<3>;
  template void
  stop_at_unknown_cell<2>(const Places<2> &,
                          const std::optional<std::size_t>,
                          const BackgroundGrid<2> &);
  template void
  stop_at_unknown_cell<3>(const Places<3> &,
                          const std::optional<std::size_t>,
                          const BackgroundGrid<3> &);
  template std::vector<ActiveCell<2>>
  owned_among_active<2>(const std::vector<ActiveCell<2>> &,
                        const BackgroundGrid<2> &);
  template std::vector<ActiveCell<3>>
  owned_among_active<3>(const std::vector<ActiveCell<3>> &,
                        const BackgroundGrid<3> &);
} // namespace emmy
