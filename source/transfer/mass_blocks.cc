#include <emmy/transfer/mass_blocks.h>

namespace emmy
{
  namespace
  {
    /** Lump, and find the damping, of a group's consistent mass. */
    void
    lump_and_damp(const double                epsilon,
                  Phases                     *phases,
                  dealii::FullMatrix<double> &mass,
                  std::vector<double>        &damping)
    {
      // the row sums of the group's matrix are its lumped mass
      const unsigned int n     = mass.m();
      double             total = 0.;
      damping.assign(n, 0.);
      for (unsigned int a = 0; a < n; ++a)
        {
          for (unsigned int b = 0; b < n; ++b)
            damping[a] += mass(a, b);
          total += damping[a];
        }
      if (epsilon > 0.)
        {
          const auto timed = effect_scope(phases, lumping_effect);
          mass *= 1. - epsilon;
          for (unsigned int a = 0; a < n; ++a)
            mass(a, a) += epsilon * damping[a];
        }
      for (double &d : damping)
        d = damping_of(d, total);
    }
  } // namespace

  template <int dim>
  void
  for_each_ghost_mass_block(const GridStart<dim>                   &start,
                            const std::function<void(MassBlock &)> &receive)
  {
    constexpr unsigned int     n = GhostFace<dim>::n_nodes;
    dealii::FullMatrix<double> mass(n, n);
    const std::vector<double>  no_damping(n);
    for (unsigned int f = 0; f < start.ghost_faces.size(); ++f)
      {
        const GhostFace<dim> &face = start.ghost_faces[f];
        mass                       = 0.;
        mass.add(face.mass, start.ghost_matrices[face.direction]);
        MassBlock block{start.active->face_nodes(f), mass, no_damping, true};
        receive(block);
      }
  }

  template <int dim>
  void
  add_mass_times(const std::vector<double> &u,
                 const Stencils<dim>       &stencils,
                 const double              *masses,
                 const GridStart<dim>      &start,
                 std::vector<double>       &result)
  {
    // m S_A of a point meets (1 - epsilon) S u + epsilon u_A
    for (const auto &group : stencils.groups)
      {
        const unsigned int *nodes = start.active->nodes(group);
        for (unsigned int p = 0; p < group.n_points; ++p)
          {
            const double           m = masses[group.first_point + p];
            dealii::Tensor<1, dim> Su;
            for (unsigned int a = 0; a < group.n_nodes; ++a)
              for (unsigned int c = 0; c < dim; ++c)
                Su[c] += stencils.value(group, a)[p] * u[dim * nodes[a] + c];
            Su *= 1. - start.lumping;
            for (unsigned int a = 0; a < group.n_nodes; ++a)
              for (unsigned int c = 0; c < dim; ++c)
                {
                  const unsigned int i = dim * nodes[a] + c;
                  result[i] += m * stencils.value(group, a)[p] *
                               (Su[c] + start.lumping * u[i]);
                }
          }
      }
    for_each_ghost_mass_block<dim>(start, [&](const MassBlock &block) {
      for (unsigned int a = 0; a < block.mass.m(); ++a)
        for (unsigned int b = 0; b < block.mass.m(); ++b)
          for (unsigned int c = 0; c < dim; ++c)
            result[dim * block.nodes[a] + c] +=
              block.mass(a, b) * u[dim * block.nodes[b] + c];
    });
  }

  template <int dim>
  void
  for_each_mass_block(const Stencils<dim>                    &stencils,
                      const double                           *masses,
                      const GridStart<dim>                   &start,
                      Phases                                 *phases,
                      const std::function<void(MassBlock &)> &receive)
  {
    dealii::FullMatrix<double> mass;
    std::vector<double>        damping;
    for (const auto &group : stencils.groups)
      {
        const unsigned int n = group.n_nodes;
        mass.reinit(n, n, true);
        for (unsigned int a = 0; a < n; ++a)
          {
            const double *S_a = stencils.value(group, a);
            for (unsigned int b = 0; b <= a; ++b)
              {
                const double *S_b = stencils.value(group, b);
                double        sum = 0.;
                for (unsigned int p = 0; p < group.n_points; ++p)
                  sum += masses[group.first_point + p] * S_a[p] * S_b[p];
                mass(a, b) = mass(b, a) = sum;
              }
          }
        lump_and_damp(start.lumping, phases, mass, damping);
        MassBlock block{start.active->nodes(group), mass, damping};
        receive(block);
      }
    for_each_ghost_mass_block(start, receive);
  }

#define INSTANTIATE(dim)                                               \
  template void for_each_mass_block<dim>(                              \
    const Stencils<dim> &,                                             \
    const double *,                                                    \
    const GridStart<dim> &,                                            \
    Phases *,                                                          \
    const std::function<void(MassBlock &)> &);                         \
  template void for_each_ghost_mass_block<dim>(                        \
    const GridStart<dim> &, const std::function<void(MassBlock &)> &); \
  template void add_mass_times<dim>(const std::vector<double> &,       \
                                    const Stencils<dim> &,             \
                                    const double *,                    \
                                    const GridStart<dim> &,            \
                                    std::vector<double> &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
