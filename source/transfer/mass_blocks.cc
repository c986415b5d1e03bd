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

    template <int dim>
    void
    hand_out_ghost_mass(const GridStart<dim>                   &start,
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
  } // namespace

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
    hand_out_ghost_mass(start, receive);
  }

  template void
  for_each_mass_block<2>(const Stencils<2> &,
                         const double *,
                         const GridStart<2> &,
                         Phases *,
                         const std::function<void(MassBlock &)> &);
  template void
  for_each_mass_block<3>(const Stencils<3> &,
                         const double *,
                         const GridStart<3> &,
                         Phases *,
                         const std::function<void(MassBlock &)> &);
} // namespace emmy
