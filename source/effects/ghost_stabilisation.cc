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
    effects.terms.push_back(
      std::make_unique<GhostStabilisation<dim>>(GhostFaces<dim>(
        mass_penalty, stiffness_penalty, effects.material_of_body)));
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
  GhostStabilisation<dim>::GhostStabilisation(GhostFaces<dim> find)
    : find(std::move(find))
  {}

  template <int dim>
  NodeCoupling<dim> *
  GhostStabilisation<dim>::coupling()
  {
    return this;
  }

  template <int dim>
  void
  GhostStabilisation<dim>::couple(
    const Stencils<dim>           &stencils,
    const BackgroundGrid<dim>     &grid,
    const BoundaryConditions<dim> &boundary_conditions,
    Couplings<dim>                &couplings)
  {
    if (matrices[0].m() == 0) // the same for all faces of a direction
      for (unsigned int d = 0; d < dim; ++d)
        matrices[d] = ghost_matrix<dim>(d, grid.cell_size());
    faces      = find(stencils, grid, boundary_conditions);
    first_node = couplings.node_ids.size();
    for (const GhostFace<dim> &face : faces)
      {
        couplings.node_ids.insert(couplings.node_ids.end(),
                                  face.node_ids.begin(),
                                  face.node_ids.end());
        couplings.group_sizes.push_back(face.node_ids.size());
      }
  }

  template <int dim>
  const unsigned int *
  GhostStabilisation<dim>::nodes(const ActiveGrid<dim> &active,
                                 const unsigned int     face) const
  {
    return active.coupled_nodes(first_node + face * GhostFace<dim>::n_nodes);
  }

  template <int dim>
  const AddedMass<dim> *
  GhostStabilisation<dim>::added_mass() const
  {
    return this;
  }

  template <int dim>
  std::string
  GhostStabilisation<dim>::loss_column() const
  {
    return "ghost_mass_loss";
  }

  template <int dim>
  void
  GhostStabilisation<dim>::hand_out(const ActiveGrid<dim> &active,
                                    const MassReceiver    &receive) const
  {
    constexpr unsigned int     n = GhostFace<dim>::n_nodes;
    dealii::FullMatrix<double> mass(n, n);
    const std::vector<double>  no_damping(n);
    for (unsigned int f = 0; f < faces.size(); ++f)
      {
        mass = 0.;
        mass.add(faces[f].mass, matrices[faces[f].direction]);
        MassBlock block{nodes(active, f), mass, no_damping};
        receive(block);
      }
  }

  template <int dim>
  double
  GhostStabilisation<dim>::kinetic_energy(const ActiveGrid<dim> &active,
                                          const Vector          &velocity) const
  {
    return 0.5 * product(active, velocity, &GhostFace<dim>::mass);
  }

  template <int dim>
  double
  GhostStabilisation<dim>::product(const ActiveGrid<dim> &active,
                                   const Vector          &v,
                                   double GhostFace<dim>::*coefficient) const
  {
    constexpr unsigned int n     = GhostFace<dim>::n_nodes;
    const auto             local = active.to_local(v);
    double                 sum   = 0.;
    for (unsigned int f = 0; f < faces.size(); ++f)
      {
        const unsigned int *node = nodes(active, f);
        const auto         &J    = matrices[faces[f].direction];
        for (unsigned int a = 0; a < n; ++a)
          for (unsigned int b = 0; b < n; ++b)
            for (unsigned int c = 0; c < dim; ++c)
              sum += faces[f].*coefficient * J(a, b) *
                     local[unknown<dim>(node[a], c)] *
                     local[unknown<dim>(node[b], c)];
      }
    return sum;
  }

  template <int dim>
  bool
  GhostStabilisation<dim>::is_force() const
  {
    return true;
  }

  template <int dim>
  std::string
  GhostStabilisation<dim>::add(const StepData<dim> &step,
                               const Iterate<dim>  &iterate,
                               Vector              &force,
                               Matrix              *jacobian) const
  {
    constexpr unsigned int     n      = GhostFace<dim>::n_nodes;
    const ActiveGrid<dim>     &active = *step.start.active;
    std::vector<double>        local_force(dim * active.n_local_nodes());
    dealii::FullMatrix<double> stiffness(dim * n, dim * n);
    for (unsigned int f = 0; f < faces.size(); ++f)
      {
        const GhostFace<dim> &face = faces[f];
        const unsigned int   *node = nodes(active, f);
        const auto           &J    = matrices[face.direction];
        stiffness                  = 0.;
        for (unsigned int a = 0; a < n; ++a)
          for (unsigned int b = 0; b < n; ++b)
            for (unsigned int c = 0; c < dim; ++c)
              {
                const double k = 0.5 * face.stiffness * J(a, b);
                local_force[unknown<dim>(node[a], c)] +=
                  k * iterate.local_displacement[unknown<dim>(node[b], c)];
                stiffness(dim * a + c, dim * b + c) = k;
              }
        if (jacobian)
          active.graph().add(node, stiffness, *jacobian);
      }
    active.add(local_force, force);
    return "";
  }

  template <int dim>
  std::vector<EnergyEntry>
  GhostStabilisation<dim>::energies(const StepData<dim> &step,
                                    const Vector        &displacement,
                                    const PointArrays<dim> &) const
  {
    std::vector<EnergyEntry> entries = energy_entries();
    entries[0].change =
      0.5 *
      product(*step.start.active, displacement, &GhostFace<dim>::stiffness);
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  GhostStabilisation<dim>::energy_entries() const
  {
    return {{"ghost_stiffness_loss", EnergyEntry::Kind::dissipated, 0.}};
  }

  template class GhostParameters<2>;
  template class GhostParameters<3>;
  template class GhostStabilisation<2>;
  template class GhostStabilisation<3>;
} // namespace emmy
