#include <emmy/math/lanes.h>
#include <emmy/transfer/mass_blocks.h>

#include <algorithm>
#include <cmath>

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

  namespace
  {
    /** Points of a few groups, as plain arrays over their nodes. */
    struct PointRows
    {
      unsigned int  n_points, n_nodes, n_padded;
      const double *rows; ///< sqrt(m) S, [q n_padded + a]
      double       *sum;  ///< [a n_padded + b]
    };
  } // namespace

  namespace mass_kernels
  {
    EMMY_CLONES void
    add_products(const PointRows &points)
    {
      const unsigned int n = points.n_padded;
      for (unsigned int q = 0; q < points.n_points; ++q)
        {
          const double *row = points.rows + q * n;
          for (unsigned int a = 0; a < points.n_nodes; ++a)
            {
              double      *target = points.sum + a * n;
              const double of_a   = row[a];
              for (unsigned int b = 0; b < n; ++b)
                target[b] += of_a * row[b];
            }
        }
    }
  } // namespace mass_kernels

  namespace
  {
    /**
     * The mass of groups that follow each other, over the nodes of all of them
     * as long as these have room: groups of few points share most nodes.
     */
    template <int dim>
    class MassPool
    {
    public:
      MassPool(const GridStart<dim> &start,
               Phases               *phases,
               const MassReceiver   &receive,
               const bool            has_small_groups)
        : start(start)
        , phases(phases)
        , receive(receive)
        , least_room(has_small_groups ? (dim == 2 ? 9 : 27) : 0)
        , index_of(start.active->n_local_nodes(),
                   dealii::numbers::invalid_unsigned_int)
      {}

      void
      add(const Stencils<dim>                 &stencils,
          const typename Stencils<dim>::Group &group,
          const double                        *masses)
      {
        take_in(start.active->nodes(group), group.n_nodes);
        rows.assign(group.n_points * n_padded, 0.);
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          {
            const double *S = stencils.value(group, a);
            for (unsigned int q = 0; q < group.n_points; ++q)
              // a root, so that the sum is symmetric to the last digit
              rows[q * n_padded + indices[a]] = std::sqrt(masses[q]) * S[q];
          }
        mass_kernels::add_products({group.n_points,
                                    static_cast<unsigned int>(members.size()),
                                    n_padded,
                                    rows.data(),
                                    sum.data()});
      }

      void
      flush()
      {
        const unsigned int n = members.size();
        if (n == 0)
          return;
        mass.reinit(n, n, true);
        for (unsigned int a = 0; a < n; ++a)
          std::copy_n(&sum[a * n_padded], n, &mass(a, 0));
        lump_and_damp(start.lumping, phases, mass, damping);
        MassBlock block{members.data(), mass, damping};
        receive(block);
        for (const unsigned int node : members)
          index_of[node] = dealii::numbers::invalid_unsigned_int;
        members.clear();
      }

    private:
      void
      take_in(const unsigned int *nodes, const unsigned int n)
      {
        unsigned int n_new = 0;
        for (unsigned int a = 0; a < n; ++a)
          n_new += index_of[nodes[a]] == dealii::numbers::invalid_unsigned_int;
        if (members.size() + n_new > room || least_room == 0)
          flush();
        if (members.empty())
          {
            constexpr unsigned int lanes = 4;
            room                         = std::max(least_room, n);
            n_padded                     = (room + lanes - 1) / lanes * lanes;
            sum.assign(n_padded * n_padded, 0.);
          }
        indices.resize(n);
        for (unsigned int a = 0; a < n; ++a)
          {
            unsigned int &index = index_of[nodes[a]];
            if (index == dealii::numbers::invalid_unsigned_int)
              {
                index = members.size();
                members.push_back(nodes[a]);
              }
            indices[a] = index;
          }
      }

      const GridStart<dim>      &start;
      Phases *const              phases;
      const MassReceiver        &receive;
      const unsigned int         least_room;
      std::vector<unsigned int>  index_of, members, indices;
      unsigned int               room = 0, n_padded = 0;
      std::vector<double>        rows, sum, damping;
      dealii::FullMatrix<double> mass;
    };
  } // namespace

  template <int dim>
  void
  for_each_mass_block(const Stencils<dim>  &stencils,
                      const double         *masses,
                      const GridStart<dim> &start,
                      Phases               *phases,
                      const MassReceiver   &receive)
  {
    constexpr unsigned int few = 4; // points in a group
    MassPool<dim>          pool(start,
                       phases,
                       receive,
                       stencils.particles.size() <
                         few * stencils.groups.size());
    for (const auto &group : stencils.groups)
      pool.add(stencils, group, masses + group.first_point);
    pool.flush();
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
