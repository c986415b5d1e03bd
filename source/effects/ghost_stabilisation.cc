#include <emmy/effects/ghost_stabilisation.h>

namespace emmy
{
  template <int dim>
  GhostParameters<dim>::GhostParameters(const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter("Mass penalty",
                        mass_penalty,
                        "gamma_M: weight of the ghost mass. 0.25 conditions "
                        "best; less loses less energy. Dimensionless, not "
                        "negative.",
                        this->prm,
                        dealii::Patterns::Double());
    this->add_parameter("Stiffness penalty",
                        stiffness_penalty,
                        "gamma_K: weight of the ghost stiffness. 0.01 for "
                        "plasticity; 0 will do for moderate steps. "
                        "Dimensionless, not negative.",
                        this->prm,
                        dealii::Patterns::Double());
  }

  template <int dim>
  void
  GhostParameters<dim>::add_to(Effects<dim> &effects, FieldLayout &) const
  {
    for (const auto &[name, value] :
         {std::pair<std::string, double>{"Mass penalty", mass_penalty},
          {"Stiffness penalty", stiffness_penalty}})
      AssertThrow(value >= 0.,
                  ExcParameter(this->path(),
                               name,
                               shortest(value),
                               "must not be negative. 0 leaves it out."));
    AssertThrow(mass_penalty > 0. || stiffness_penalty > 0.,
                ExcParameter(this->path(),
                             "Mass penalty",
                             shortest(mass_penalty),
                             "both penalties are zero. Give one, or take "
                             "<ghost stabilisation> from Effects/Names."));
    effects.terms.push_back(std::make_unique<GhostStiffness<dim>>());
    effects.ghost_faces =
      std::make_unique<const GhostFaces<dim>>(mass_penalty,
                                              stiffness_penalty,
                                              effects.material_of_body);
  }

  template <int dim>
  EffectCard
  GhostParameters<dim>::card()
  {
    EffectCard card;
    card.enters  = "particles to grid: faces and mass; Newton: stiffness";
    card.couples = "the nodes of the two cells at each ghost face";
    card.ledger_columns = {"ghost_stiffness_loss", "ghost_mass_loss"};
    return card;
  }

  template <int dim>
  std::string
  GhostStiffness<dim>::add(const StepData<dim> &step,
                           const Iterate<dim>  &iterate,
                           Vector              &force,
                           Matrix              *jacobian) const
  {
    constexpr unsigned int     n      = GhostFace<dim>::n_nodes;
    const ActiveGrid<dim>     &active = *step.start.active;
    std::vector<double>        local_force(dim * active.n_local_nodes());
    dealii::FullMatrix<double> stiffness(dim * n, dim * n);
    for (unsigned int f = 0; f < step.start.ghost_faces.size(); ++f)
      {
        const GhostFace<dim> &face  = step.start.ghost_faces[f];
        const unsigned int   *nodes = active.face_nodes(f);
        const auto           &J     = step.start.ghost_matrices[face.direction];
        stiffness                   = 0.;
        for (unsigned int a = 0; a < n; ++a)
          for (unsigned int b = 0; b < n; ++b)
            for (unsigned int c = 0; c < dim; ++c)
              {
                const double k = 0.5 * face.stiffness * J(a, b);
                local_force[dim * nodes[a] + c] +=
                  k * iterate.local_displacement[dim * nodes[b] + c];
                stiffness(dim * a + c, dim * b + c) = k;
              }
        if (jacobian)
          active.graph().add(nodes, stiffness, *jacobian);
      }
    active.add(local_force, force);
    return "";
  }

  template <int dim>
  std::vector<EnergyEntry>
  GhostStiffness<dim>::energies(const StepData<dim> &step,
                                const Vector        &displacement,
                                const PointArrays<dim> &) const
  {
    std::vector<EnergyEntry> entries = energy_entries();
    entries[0].change =
      0.5 * step.start.ghost_product(displacement, &GhostFace<dim>::stiffness);
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  GhostStiffness<dim>::energy_entries() const
  {
    return {{"ghost_stiffness_loss", EnergyEntry::Kind::dissipated, 0.}};
  }

  template class GhostParameters<2>;
  template class GhostParameters<3>;
  template class GhostStiffness<2>;
  template class GhostStiffness<3>;
} // namespace emmy
