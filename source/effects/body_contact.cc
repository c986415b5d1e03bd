#include <emmy/base/text.h>
#include <emmy/effects/body_contact.h>

#include <algorithm>
#include <numeric>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    constexpr unsigned int none = std::numeric_limits<unsigned int>::max();
  } // namespace

  template <int dim>
  BodyContact<dim>::BodyContact(ContactRules<dim>                 given,
                                std::vector<std::string>          group_names,
                                const Fields                     &fields,
                                std::vector<ParticleCorners<dim>> corners)
    : rules(std::move(given))
    , group_names(std::move(group_names))
    , fields(fields)
    , corners_of_body(std::move(corners))
    , points_of_body(contact_points(rules))
    , least_margin(0.25 * rules.largest_reach() / rules.radius *
                   rules.points_per_direction)
    , margin(4. * least_margin) // it is not known yet how bodies move
  {
    found.force.resize(this->group_names.size());
  }

  template <int dim>
  std::vector<std::vector<Tensor<1, dim>>>
  BodyContact<dim>::contact_points(const ContactRules<dim> &rules)
  {
    std::vector<std::vector<Tensor<1, dim>>> result(rules.bodies.size());
    for (unsigned int body = 0; body < result.size(); ++body)
      for (unsigned int k = 0; k < rules.n_points(); ++k)
        result[body].push_back(rules.point(body, k));
    return result;
  }

  template <int dim>
  std::string
  BodyContact<dim>::mark(const BackgroundGrid<dim>               &grid,
                         dealii::Particles::ParticleHandler<dim> &given) const
  {
    const MPI_Comm     communicator = grid.communicator();
    const unsigned int here =
      dealii::Utilities::MPI::this_mpi_process(communicator);
    std::vector<ContactParticle<dim>> particles;
    for (const auto &particle : given)
      {
        const auto         properties = particle.get_properties();
        const unsigned int body       = properties[fields.body];
        if (rules.bodies[body].group == none)
          continue;
        Tensor<2, dim> F;
        for (unsigned int i = 0; i < dim * dim; ++i)
          F[i / dim][i % dim] = properties[fields.deformation_gradient + i];
        particles.push_back({particle.get_id(),
                             body,
                             here,
                             particles.size(),
                             particle.get_location(),
                             F});
      }
    const auto near = find_candidates(
      rules,
      with_those_near(rules, std::move(particles), 0., communicator),
      0.,
      here);
    found.overlap  = 0.;
    double deepest = 0.;
    for (const ParticlePair &pair : near.pairs)
      {
        const auto &one = near.particles[pair.first],
                   &two = near.particles[pair.second];
        if (one.owner != here)
          continue;
        const PairLaw law = rules.law(one.body, two.body);
        for (const auto &[i, j] : pair.points)
          {
            const Tensor<1, dim> x =
              one.place + one.F * rules.point(one.body, i) - two.place -
              two.F * rules.point(two.body, j);
            const double gap = x.norm() - law.reach;
            found.overlap += pair_energy(law, gap);
            deepest = std::max(deepest, -gap / law.reach);
          }
      }
    const double stored =
      dealii::Utilities::MPI::sum(found.overlap, grid.communicator());
    deepest = dealii::Utilities::MPI::max(deepest, grid.communicator());
    return "contact between " + join(group_names) + ": points act from " +
           brief(rules.largest_reach()) + " m on" +
           (stored > 0.
              ? "; some are nearer at the start, by up to " + brief(deepest) +
                  " of that, which stores " + brief(stored) + " J"
              : std::string());
  }

  template <int dim>
  std::vector<double>
  BodyContact<dim>::contents() const
  {
    std::vector<double> result{margin};
    for (const auto &[key, spring] : springs)
      {
        for (const std::uint64_t part : key)
          result.push_back(part); // exact up to 2^53
        for (unsigned int d = 0; d < dim; ++d)
          result.push_back(spring[d]);
      }
    return result;
  }

  template <int dim>
  void
  BodyContact<dim>::recall(const std::vector<std::vector<double>> &parts)
  {
    margin = parts.at(0).at(0);
    springs.clear();
    for (std::size_t part = 1; part < parts.size(); ++part)
      for (std::size_t i = 1; i < parts[part].size(); i += 4 + dim)
        {
          const auto from = parts[part].begin() + i;
          PairKey    key;
          std::copy_n(from, key.size(), key.begin());
          Tensor<1, dim> &spring = springs[key];
          for (unsigned int d = 0; d < dim; ++d)
            spring[d] = from[4 + d];
        }
  }

  template <int dim>
  std::vector<ContactParticle<dim>>
  BodyContact<dim>::in_groups(const Stencils<dim>    &stencils,
                              const PointArrays<dim> &points,
                              const unsigned int      rank) const
  {
    std::vector<ContactParticle<dim>> result;
    for (std::size_t p = 0; p < points.n_points(); ++p)
      {
        const unsigned int body = points.component(fields.body)[p];
        if (rules.bodies[body].group != none)
          result.push_back(
            {stencils.particles[p]->get_id(),
             body,
             rank,
             stencils.order[p],
             points.point(p),
             tensor_field(points, fields.deformation_gradient, p)});
      }
    return result;
  }

  template <int dim>
  void
  BodyContact<dim>::classify(const Stencils<dim>       &stencils,
                             const PointArrays<dim>    &points,
                             const BackgroundGrid<dim> &grid)
  {
    const MPI_Comm communicator = grid.communicator();
    here = dealii::Utilities::MPI::this_mpi_process(communicator);
    candidates =
      find_candidates(rules,
                      with_those_near(rules,
                                      in_groups(stencils, points, here),
                                      margin,
                                      communicator),
                      margin,
                      here);
    laws.clear();
    for (const ParticlePair &pair : candidates.pairs)
      laws.push_back(rules.law(candidates.particles[pair.first].body,
                               candidates.particles[pair.second].body));
    places.clear();
    for (const ContactParticle<dim> &particle : candidates.particles)
      for (const Tensor<1, dim> &xi : points_of_body[particle.body])
        places.push_back(particle.place + particle.F * xi);
    is_coupled.assign(candidates.pairs.size(), false);
    exchange.begin(candidates, communicator);
    if (has_friction())
      springs_held = exchange.springs_of(candidates, springs);
  }

  template <int dim>
  void
  BodyContact<dim>::end_step(const double, const double)
  {
    springs = std::move(found.springs);
    found.springs.clear();
  }

  template <int dim>
  std::vector<EnergyEntry>
  BodyContact<dim>::energy_entries() const
  {
    using Kind = EnergyEntry::Kind;
    std::vector<EnergyEntry> entries{{"contact_energy", Kind::stored, 0.}};
    if (has_friction())
      {
        entries.push_back({"friction_energy", Kind::stored, 0.});
        entries.push_back({"friction_dissipation", Kind::dissipated, 0.});
      }
    entries.push_back({"contact_overlap_work", Kind::work, 0.});
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  BodyContact<dim>::energies_at_start(const PointArrays<dim> &,
                                      const double) const
  {
    std::vector<EnergyEntry> entries = energy_entries();
    entries.front().change = entries.back().change = found.overlap;
    return entries;
  }

  template <int dim>
  std::vector<std::string>
  BodyContact<dim>::columns_of(const std::vector<std::string> &group_names)
  {
    std::vector<std::string> columns;
    for (const std::string &name : group_names)
      for (unsigned int d = 0; d < dim; ++d)
        columns.push_back("contact_" + name + "_force_" + "xyz"[d]);
    columns.push_back("contact_pairs");
    return columns;
  }

  template <int dim>
  std::vector<StepMeasure>
  BodyContact<dim>::measure(const PointArrays<dim> &,
                            const double,
                            const BackgroundGrid<dim> &grid)
  {
    std::vector<double> values;
    for (const Tensor<1, dim> &force : found.force)
      for (unsigned int d = 0; d < dim; ++d)
        values.push_back(force[d]);
    values.push_back(found.n_touching);
    dealii::Utilities::MPI::sum(values, grid.communicator(), values);
    const auto               names = columns_of(group_names);
    std::vector<StepMeasure> result;
    for (unsigned int i = 0; i < values.size(); ++i)
      result.push_back({names[i], values[i]});
    return result;
  }

  template class BodyContact<2>;
  template class BodyContact<3>;
} // namespace emmy
