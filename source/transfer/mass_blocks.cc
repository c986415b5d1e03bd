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
      // the second part is for nodes with S = 0 at all points; it must be far
      // below any S^2 that is not zero
      for (double &d : damping)
        d = mass_damping * d + 1e-30 * total;
    }
  } // namespace

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
    if (start.hand_out_mass)
      start.hand_out_mass(*start.active, receive);
  }

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
