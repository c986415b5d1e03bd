#include <emmy/system/neighbourhood.h>
#include <emmy/transfer/mass_blocks.h>

namespace emmy
{
  namespace
  {
    /** That of a group, whose nodes stand at @p places in the matrix. */
    template <int dim>
    void
    add_consistent_mass(const Stencils<dim>                 &stencils,
                        const typename Stencils<dim>::Group &group,
                        const double                        *masses,
                        const unsigned int                  *places,
                        dealii::FullMatrix<double>          &mass)
    {
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        {
          const double *S_a = stencils.value(group, a);
          for (unsigned int b = 0; b <= a; ++b)
            {
              const double *S_b = stencils.value(group, b);
              double        sum = 0.;
              for (unsigned int p = 0; p < group.n_points; ++p)
                sum += masses[group.first_point + p] * S_a[p] * S_b[p];
              mass(places[a], places[b]) += sum;
              if (a != b)
                mass(places[b], places[a]) += sum;
            }
        }
    }

    /** Lump, and find the damping, of a consistent mass. */
    void
    lump_and_damp(const double                epsilon,
                  Phases                     *phases,
                  dealii::FullMatrix<double> &mass,
                  std::vector<double>        &damping)
    {
      // the row sums of the matrix are the lumped mass
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
    std::vector<double> Su; // of the points of a group, by component
    for (const auto &group : stencils.groups)
      {
        const unsigned int *nodes = start.active->nodes(group);
        const unsigned int  n     = group.n_points;
        const double       *m     = masses + group.first_point;
        Su.assign(dim * n, 0.);
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          for (unsigned int c = 0; c < dim; ++c)
            {
              const double *S   = stencils.value(group, a);
              const double  u_a = u[unknown<dim>(nodes[a], c)];
              for (unsigned int p = 0; p < n; ++p)
                Su[c * n + p] += S[p] * u_a;
            }
        for (unsigned int c = 0; c < dim; ++c)
          for (unsigned int p = 0; p < n; ++p)
            Su[c * n + p] *= m[p] * (1. - start.lumping);
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          {
            const double *S      = stencils.value(group, a);
            double        lumped = 0.;
            for (unsigned int p = 0; start.lumping > 0. && p < n; ++p)
              lumped += start.lumping * m[p] * S[p];
            for (unsigned int c = 0; c < dim; ++c)
              {
                const unsigned int i   = unknown<dim>(nodes[a], c);
                double             sum = lumped * u[i];
                for (unsigned int p = 0; p < n; ++p)
                  sum += S[p] * Su[c * n + p];
                result[i] += sum;
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
    Neighbourhood<dim>         around(stencils, *start.active);
    const auto                 end = stencils.groups.end();
    for (auto group = stencils.groups.begin(); group != end;)
      {
        around.begin(*group);
        mass.reinit(around.nodes().size(), around.nodes().size());
        for (; group != end && around.has(*group); ++group)
          add_consistent_mass<dim>(
            stencils, *group, masses, around.places(*group), mass);
        lump_and_damp(start.lumping, phases, mass, damping);
        MassBlock block{around.nodes().data(), mass, damping};
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
