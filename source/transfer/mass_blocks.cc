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
                Su[c] +=
                  stencils.value(group, a)[p] * u[unknown<dim>(nodes[a], c)];
            Su *= 1. - start.lumping;
            for (unsigned int a = 0; a < group.n_nodes; ++a)
              for (unsigned int c = 0; c < dim; ++c)
                {
                  const unsigned int i = unknown<dim>(nodes[a], c);
                  result[i] += m * stencils.value(group, a)[p] *
                               (Su[c] + start.lumping * u[i]);
                }
          }
      }
    start.hand_out_added_mass([&](const MassBlock &block) {
      for (unsigned int a = 0; a < block.mass.m(); ++a)
        for (unsigned int b = 0; b < block.mass.m(); ++b)
          for (unsigned int c = 0; c < dim; ++c)
            result[unknown<dim>(block.nodes[a], c)] +=
              block.mass(a, b) * u[unknown<dim>(block.nodes[b], c)];
    });
  }

  template <int dim>
  void
  for_each_mass_block(const Stencils<dim>  &stencils,
                      const double         *masses,
                      const GridStart<dim> &start,
                      Phases               *phases,
                      const MassReceiver   &receive)
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
    start.hand_out_added_mass(receive);
  }

  template void
  add_mass_times<2>(const std::vector<double> &,
                    const Stencils<2> &,
                    const double *,
                    const GridStart<2> &,
                    std::vector<double> &);
  template void
  add_mass_times<3>(const std::vector<double> &,
                    const Stencils<3> &,
                    const double *,
                    const GridStart<3> &,
                    std::vector<double> &);
  template void
  for_each_mass_block<2>(const Stencils<2> &,
                         const double *,
                         const GridStart<2> &,
                         Phases *,
                         const MassReceiver &);
  template void
  for_each_mass_block<3>(const Stencils<3> &,
                         const double *,
                         const GridStart<3> &,
                         Phases *,
                         const MassReceiver &);
} // namespace emmy
