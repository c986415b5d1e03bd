#include <emmy/math/four_numbers.h>
#include <emmy/particles/with_n_points.h>
#include <emmy/system/neighbourhood.h>
#include <emmy/transfer/mass_blocks.h>

#include <array>

// vectors stay within this file
#pragma GCC diagnostic ignored "-Wpsabi"

namespace emmy
{
  namespace
  {
    /** Points whose rows stay in the first-level cache. */
    constexpr unsigned int most_points = 16;

    /** Some points, and what they reach of a neighbourhood's nodes. */
    struct MassPoints
    {
      std::vector<double> masses;
      std::vector<double> S; ///< point by point; rows over the nodes
      unsigned int        n_nodes = 0, n_padded = 0;
      std::vector<double> sum; ///< of m S_a S_b, b <= a: [a n_padded + b]
    };
  } // namespace

  namespace mass_kernels
  {
    // no template: it has no clones
    EMMY_CLONES void
    add(MassPoints &points)
    {
      const unsigned int n = points.n_padded, n_points = points.masses.size();
      const double      *S = points.S.data();
      std::array<double, most_points> momenta;
      for (unsigned int a = 0; a < points.n_nodes; ++a)
        {
          for (unsigned int q = 0; q < n_points; ++q)
            momenta[q] = points.masses[q] * S[q * n + a];
          double *row = &points.sum[a * n];
          for (unsigned int b = 0; b <= a; b += n_together)
            {
              auto sum = read_together(row + b);
              for (unsigned int q = 0; q < n_points; ++q)
                sum += momenta[q] * read_together(S + q * n + b);
              write_together(sum, row + b);
            }
        }
    }
  } // namespace mass_kernels

  namespace
  {
    /** The consistent mass of a neighbourhood. */
    template <int dim>
    void
    find_consistent_mass(const Stencils<dim>                 &stencils,
                         const typename Stencils<dim>::Group &first,
                         const Neighbourhood<dim>            &around,
                         const double                        *masses,
                         MassPoints                          &points,
                         dealii::FullMatrix<double>          &mass)
    {
      const unsigned int n = points.n_nodes = around.nodes().size();
      points.n_padded = (n + n_together - 1) / n_together * n_together;
      points.sum.assign(n * points.n_padded, 0.);
      const auto add = [&] {
        mass_kernels::add(points);
        points.masses.clear();
        points.S.clear();
      };
      for (auto group = &first; group != around.end(); ++group)
        for (unsigned int p = 0; p < group->n_points; ++p)
          {
            points.masses.push_back(masses[group->first_point + p]);
            points.S.resize(points.masses.size() * points.n_padded, 0.);
            double *S = &points.S[points.S.size() - points.n_padded];
            for (unsigned int a = 0; a < group->n_nodes; ++a)
              S[around.places(*group)[a]] = stencils.value(*group, a)[p];
            if (points.masses.size() == most_points)
              add();
          }
      add();
      mass.reinit(n, n, /*omit_default_initialization=*/true);
      for (unsigned int a = 0; a < n; ++a)
        for (unsigned int b = 0; b <= a; ++b)
          mass(a, b) = mass(b, a) = points.sum[a * points.n_padded + b];
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
      with_n_points(group.n_points, [&](const auto n_points) {
        const unsigned int  n     = n_points;
        const unsigned int *nodes = start.active->nodes(group);
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
      });
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
    MassPoints                 points;
    Neighbourhood<dim>         around(stencils, *start.active);
    const auto *const end = stencils.groups.data() + stencils.groups.size();
    for (const auto *group = stencils.groups.data(); group != end;)
      {
        around.begin(*group);
        find_consistent_mass(stencils, *group, around, masses, points, mass);
        lump_and_damp(start.lumping, phases, mass, damping);
        MassBlock block{around.nodes().data(), mass, damping};
        receive(block);
        group = around.end();
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
