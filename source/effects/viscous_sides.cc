#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/viscous_sides.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  template <int dim>
  ViscousSidesParameters<dim>::ViscousSidesParameters(
    const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter(
      "Sides",
      sides,
      "Sides of the grid where waves leave: a list of x-min, "
      "x-max, y-min, y-max, z-min, z-max. Material must "
      "stand at them. What <Fixed> or <Roller> hold there takes "
      "nothing up. Required if viscous sides is named.");
  }

  template <int dim>
  void
  ViscousSidesParameters<dim>::add_to(Effects<dim> &effects,
                                      FieldLayout  &layout) const
  {
    AssertThrow(!sides.empty(),
                ExcParameter(this->path(),
                             "Sides",
                             "",
                             "it is required: sides of the grid where waves "
                             "leave, e.g. x-min, x-max."));
    std::vector<unsigned int> numbers;
    for (const std::string &side : sides)
      {
        numbers.push_back(side_number(side, dim, this->path(), "Sides"));
        AssertThrow(std::count(sides.begin(), sides.end(), side) == 1,
                    ExcParameter(this->path(),
                                 "Sides",
                                 join(sides),
                                 "<" + side +
                                   "> stands there twice. Remove "
                                   "one of them."));
      }
    std::vector<typename ViscousSides<dim>::Waves> waves;
    for (const Material<dim> *material : effects.material_of_body)
      waves.push_back(
        {std::sqrt(material->p_wave_modulus() / material->density()),
         std::sqrt(material->shear_wave_modulus() / material->density())});
    effects.terms.push_back(
      std::make_unique<ViscousSides<dim>>(numbers, waves, layout["mass"]));
  }

  template <int dim>
  EffectCard
  ViscousSidesParameters<dim>::card()
  {
    EffectCard card;
    card.enters         = "Newton: a force on the nodes of these sides";
    card.ledger_columns = {"radiated_energy"};
    return card;
  }

  template <int dim>
  ViscousSides<dim>::ViscousSides(std::vector<unsigned int> sides,
                                  std::vector<Waves>        waves_of_body,
                                  const unsigned int        mass)
    : sides(std::move(sides))
    , waves_of_body(std::move(waves_of_body))
    , mass(mass)
  {}

  template <int dim>
  void
  ViscousSides<dim>::classify(const Stencils<dim> &,
                              const PointArrays<dim> &,
                              const BackgroundGrid<dim> &grid)
  {
    this->grid = &grid;
  }

  template <int dim>
  std::vector<double>
  ViscousSides<dim>::stiffness(const StepData<dim> &step) const
  {
    const ActiveGrid<dim> &active = *step.start.active;
    const double          *masses = step.points.component(mass);
    std::vector<double>    result(dim * active.n_local_nodes());
    for (const auto &group : step.stencils.groups)
      for (const unsigned int side : sides)
        {
          const unsigned int normal = side / 2;
          const double       sign   = side % 2 ? 1. : -1.;
          const double       place  = side % 2 ? grid->upper_corner()[normal]
                                               : grid->lower_corner()[normal];
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            {
              const unsigned int node = active.nodes(group)[a];
              if (std::abs(active.position(node)[normal] - place) >
                  1e-6 * active.shortest_side())
                continue;
              const double *dS     = step.stencils.gradient(group, a, normal);
              double        m_by_h = 0.;
              for (unsigned int p = 0; p < group.n_points; ++p)
                m_by_h += masses[group.first_point + p] * sign * dS[p];
              const Waves &waves = waves_of_body[group.body];
              for (unsigned int c = 0; c < dim; ++c)
                result[unknown<dim>(node, c)] +=
                  m_by_h * (c == normal ? waves.pressure : waves.shear) /
                  step.time_step;
            }
        }
    return result;
  }

  template <int dim>
  std::string
  ViscousSides<dim>::add(const StepData<dim> &step,
                         const Iterate<dim>  &iterate,
                         Vector              &force,
                         Matrix              *jacobian) const
  {
    const ActiveGrid<dim>     &active = *step.start.active;
    const auto                 k      = stiffness(step);
    std::vector<double>        local_force(k.size());
    dealii::FullMatrix<double> block(dim, dim);
    for (unsigned int node = 0; node < active.n_local_nodes(); ++node)
      {
        bool acts = false;
        for (unsigned int c = 0; c < dim; ++c)
          {
            const unsigned int i = unknown<dim>(node, c);
            local_force[i]       = k[i] * iterate.local_displacement[i];
            block(c, c)          = k[i];
            acts                 = acts || k[i] != 0.;
          }
        // where places follow the nodes, the small part by which they move the
        // force is left out of the derivative
        if (jacobian && acts)
          active.graph().add(&node, block, *jacobian);
      }
    active.add(local_force, force);
    return "";
  }

  template <int dim>
  std::vector<EnergyEntry>
  ViscousSides<dim>::energies(const StepData<dim> &step,
                              const Vector        &displacement,
                              const PointArrays<dim> &) const
  {
    const auto k       = stiffness(step);
    const auto u       = step.start.active->to_local(displacement);
    auto       entries = energy_entries();
    for (std::size_t i = 0; i < u.size(); ++i)
      entries[0].change += k[i] * u[i] * u[i];
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  ViscousSides<dim>::energy_entries() const
  {
    return {{"radiated_energy", EnergyEntry::Kind::dissipated, 0.}};
  }

  template class ViscousSidesParameters<2>;
  template class ViscousSidesParameters<3>;
  template class ViscousSides<2>;
  template class ViscousSides<3>;
} // namespace emmy
