#include <emmy/effects/inertia.h>
#include <emmy/effects/moving_places.h>
#include <emmy/effects/node_lanes.h>
#include <emmy/particles/with_n_points.h>
#include <emmy/transfer/mass_blocks.h>

#include <algorithm>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** By elimination with the largest pivots of the columns. */
    template <int n>
    Tensor<2, n>
    inverse_of(Tensor<2, n> matrix)
    {
      Tensor<2, n> inverse;
      for (int i = 0; i < n; ++i)
        inverse[i][i] = 1.;
      for (int i = 0; i < n; ++i)
        {
          int pivot = i;
          for (int k = i + 1; k < n; ++k)
            if (std::abs(matrix[k][i]) > std::abs(matrix[pivot][i]))
              pivot = k;
          if (pivot != i)
            {
              std::swap(matrix[i], matrix[pivot]);
              std::swap(inverse[i], inverse[pivot]);
            }
          const double scale = 1. / matrix[i][i];
          matrix[i] *= scale;
          inverse[i] *= scale;
          for (int k = 0; k < n; ++k)
            if (k != i && matrix[k][i] != 0.)
              {
                const double factor = matrix[k][i];
                matrix[k] -= factor * matrix[i];
                inverse[k] -= factor * inverse[i];
              }
        }
      return inverse;
    }

    /**
     * (I - Q_q)^-1 (Q - q), and (I - Q_q)^-1 times Q_u, where Q depends on
     * n_used coordinates of the place: they decide by themselves, and the
     * others follow.
     * @param from_place Q - q
     * @param box        null: it stays
     */
    template <int dim, int n_used>
    typename MovingPlaces<dim>::Response
    response_to(const PointRows<dim>     &point,
                const Tensor<1, 2 * dim> &from_place,
                const MiddleBox<dim>     *box)
    {
      Tensor<2, n_used> matrix;           // I - Q_q
      double            Q_q[dim][n_used]; // of the box
      for (int k = 0; k < n_used; ++k)
        for (int d = 0; d < dim; ++d)
          {
            const auto &motion = point.motion_by_q[k];
            matrix[d][k]       = (d == k ? 1. : 0.) - 0.5 * motion[0][d];
            double sum         = 0.;
            for (int c = 0; box && c < dim; ++c)
              for (int e = 0; e < dim; ++e)
                sum += box->by_L[d][c][e] * motion[1 + e][c];
            Q_q[d][k] = sum;
          }
      for (int r = dim; r < n_used; ++r)
        for (int k = 0; k < n_used; ++k)
          matrix[r][k] = (r == k ? 1. : 0.) - Q_q[point.used[r] - dim][k];
      Tensor<2, n_used> inverse;
      if constexpr (n_used == dim)
        inverse = invert(matrix);
      else
        inverse = inverse_of(matrix);

      typename MovingPlaces<dim>::Response result;
      for (int r = 0; r < n_used; ++r)
        {
          const unsigned int k = point.used[r];
          for (int s = 0; s < n_used; ++s)
            result.shift[k] += inverse[r][s] * from_place[point.used[s]];
          for (int j = 0; j < dim; ++j)
            {
              auto &by_motion = result.by_motion[k][j];
              by_motion[0]    = 0.5 * inverse[r][j];
              for (int s = dim; s < n_used; ++s)
                for (int d = 0; d < dim; ++d)
                  by_motion[1 + d] +=
                    inverse[r][s] * box->by_L[point.used[s] - dim][j][d];
            }
        }
      for (unsigned int e = 0, r = dim; box && e < dim; ++e)
        if (r < n_used && point.used[r] == dim + e)
          ++r;
        else // a length on which no weight depends
          {
            const unsigned int k = dim + e;
            result.shift[k]      = from_place[k];
            for (int j = 0; j < dim; ++j)
              for (int d = 0; d < dim; ++d)
                result.by_motion[k][j][1 + d] = box->by_L[e][j][d];
            for (int s = 0; s < n_used; ++s)
              {
                const unsigned int from = point.used[s];
                result.shift[k] += Q_q[e][s] * result.shift[from];
                for (int j = 0; j < dim; ++j)
                  result.by_motion[k][j] +=
                    Q_q[e][s] * result.by_motion[from][j];
              }
          }
      return result;
    }
  } // namespace

  template <int dim>
  MovingPlaces<dim>::MovingPlaces(const PlaceRules<dim> &rules,
                                  const Places<dim>     &places)
    : rules(rules)
    , places(places)
    , mass(rules.layout["mass"])
    , velocity(rules.layout["velocity"])
    , responses(places.size())
    , has_boxes(rules.domain_update && !places.half_lengths.empty())
  {}

  template <int dim>
  void
  MovingPlaces<dim>::begin(const StepData<dim> &step,
                           std::vector<double>  point_forces)
  {
    this->point_forces = std::move(point_forces);
    share.assign(dim * step.start.active->n_local_nodes(), 0.);
    defect = 0.;
  }

  template <int dim>
  const std::vector<double> &
  MovingPlaces<dim>::residual_share() const
  {
    return share;
  }

  template <int dim>
  void
  MovingPlaces<dim>::add_to_share(const std::vector<double> &local)
  {
    for (std::size_t i = 0; i < share.size(); ++i)
      share[i] += local[i];
  }

  template <int dim>
  double
  MovingPlaces<dim>::largest_defect() const
  {
    return defect;
  }

  template <int dim>
  void
  MovingPlaces<dim>::find_defect(const StepData<dim>       &step,
                                 const std::vector<double> &u)
  {
    std::vector<double> motion;
    for (const Group &group : step.stencils.groups)
      {
        find_motions(step, group, u, /*with_gradients=*/false, motion);
        for (unsigned int q = 0; q < group.n_points; ++q)
          {
            const std::size_t p     = group.first_point + q;
            const std::size_t i     = step.stencils.order[p];
            const auto       &sides = rules.grid.size_of(places.cells[i]);
            for (unsigned int d = 0; d < dim; ++d)
              {
                const double x = step.points.position(d)[p] +
                                 0.5 * motion[d * group.n_points + q] -
                                 places.positions[i][d];
                defect = std::max(defect, std::abs(x) / sides[d]);
              }
          }
      }
  }

  template <int dim>
  void
  MovingPlaces<dim>::begin_neighbourhood(const Neighbourhood<dim>  &around,
                                         const std::vector<double> &u)
  {
    work.n_nodes         = around.nodes().size();
    const unsigned int n = work.n_padded = padded<dim>(work.n_nodes);
    const auto         begin = [](Rows &rows, const unsigned int size) {
      rows.resize_fast(size);
      std::fill(rows.begin(), rows.end(), 0.);
    };
    work.sum.resize_fast(dim * dim * n * n);
    work.is_empty = true;
    begin(work.share, dim * n);
    begin(work.diagonal, n);
    begin(work.u, dim * n);
    for (unsigned int a = 0; a < work.n_nodes; ++a)
      for (unsigned int c = 0; c < dim; ++c)
        work.u[c * n + a] = u[unknown<dim>(around.nodes()[a], c)];
    work.weights.resize_fast(most_points_at_once * (dim + 1) * n);
    work.by_motion.resize_fast(most_points_at_once * dim * (dim + 1) * dim * n);
    work.weights_by_q.resize_fast(nq * (dim + 1) * n);
  }

  template <int dim>
  void
  MovingPlaces<dim>::add(const Points &points)
  {
    set_weights(points.here);
    for (unsigned int at = 0; at < points.here.points.size(); ++at)
      add_point(points, at);
    add_products<dim>(work.reach,
                      work.n_nodes,
                      work.is_empty,
                      work.by_motion.data(),
                      work.weights.data(),
                      work.sum.data());
    work.is_empty = false;
  }

  template <int dim>
  void
  MovingPlaces<dim>::set_weights(const NeighbourPoints<dim> &here)
  {
    const unsigned int n = work.n_padded;
    work.reach.reinit(n);
    std::fill_n(work.weights.begin(), here.points.size() * (dim + 1) * n, 0.);
    double *rows = work.weights.data();
    for (unsigned int at = 0; at < here.points.size(); ++at)
      {
        const auto &[group, q]     = here.points[at];
        const unsigned int *places = here.around.places(*group);
        for (unsigned int a = 0; a < group->n_nodes; ++a)
          {
            work.reach.add(at, places[a]);
            rows[places[a]] = here.stencils.value(*group, a)[q];
            for (unsigned int d = 0; d < dim; ++d)
              rows[(1 + d) * n + places[a]] =
                here.stencils.gradient(*group, a, d)[q];
          }
        rows += (dim + 1) * n;
      }
  }

  template <int dim>
  void
  MovingPlaces<dim>::set_weights_by_place(const NeighbourPoints<dim> &here,
                                          const unsigned int          at)
  {
    const auto &[group, q]     = here.points[at];
    const unsigned int *places = here.around.places(*group);
    const unsigned int  n      = work.n_padded;
    rules.shape_functions.differentiate(
      this->places,
      here.stencils.order[group->first_point + q],
      *group,
      rules.grid,
      work.derivatives);
    for (unsigned int k = 0; k < (has_boxes ? nq : dim); ++k)
      for (unsigned int l = 0; l <= dim && work.derivatives.depends[k]; ++l)
        {
          double       *to   = &work.weights_by_q[(k * (dim + 1) + l) * n];
          const double *from = work.derivatives.row(k, l);
          std::fill_n(to, n, 0.);
          for (unsigned int a = 0; a < group->n_nodes; ++a)
            to[places[a]] = from[a];
        }
  }

  template <int dim>
  ComponentBlocks
  MovingPlaces<dim>::finish_neighbourhood(const Neighbourhood<dim> &around)
  {
    const std::size_t n = work.n_padded;
    for (unsigned int a = 0; a < work.n_nodes; ++a)
      for (unsigned int i = 0; i < dim; ++i)
        {
          share[unknown<dim>(around.nodes()[a], i)] += work.share[i * n + a];
          work.sum[((a * dim + i) * n + a) * dim + i] += work.diagonal[a];
        }
    return {work.sum.data(), work.n_nodes, dim * n, 1, dim * dim * n, dim};
  }

  template <int dim>
  void
  MovingPlaces<dim>::add_point(const Points &points, const unsigned int at)
  {
    const NeighbourPoints<dim> &here = points.here;
    const std::size_t           p =
      here.points[at].group->first_point + here.points[at].q;
    const unsigned int n = work.n_padded;
    set_weights_by_place(here, at);

    PointRows<dim> point;
    point.n_padded  = n;
    point.registers = work.reach.template registers<node_lanes<dim>>(at);
    point.n_used    = 0;
    for (unsigned int k = 0; k < (has_boxes ? nq : dim); ++k)
      if (work.derivatives.depends[k])
        point.used[point.n_used++] = k;
    point.u            = work.u.data();
    point.weights      = &work.weights[at * (dim + 1) * n];
    point.weights_by_q = work.weights_by_q.data();
    point.by_motion    = &work.by_motion[at * dim * (dim + 1) * dim * n];
    point.share        = work.share.data();
    point.diagonal     = work.diagonal.data();
    point.find_motion();
    responses[p] = response(points, at, point);
    set_force(points, at, point);
    for (unsigned int k = 0; k < point.n_used; ++k)
      {
        point.shift[k] = responses[p].shift[point.used[k]];
        for (unsigned int j = 0; j < dim; ++j)
          for (unsigned int l = 0; l <= dim; ++l)
            point.by_motion_of_q[k][j][l] =
              responses[p].by_motion[point.used[k]][j][l];
      }
    point.find_rows();
  }

  template <int dim>
  typename MovingPlaces<dim>::Response
  MovingPlaces<dim>::response(const Points         &points,
                              const unsigned int    at,
                              const PointRows<dim> &point)
  {
    const StepData<dim> &step   = points.step;
    const auto &[group, q]      = points.here.points[at];
    const unsigned int in_batch = points.here.at + at;
    const std::size_t  p        = group->first_point + q;
    const std::size_t  i        = step.stencils.order[p];
    MiddleBox<dim>     middle;
    if (has_boxes)
      middle = rules.domain_update->middle(step.points,
                                           p,
                                           group->body,
                                           points.middle.from_start(in_batch));
    if (has_boxes && points.box_scales)
      for (unsigned int d = 0; d < dim; ++d)
        {
          middle.half_length[d] *= points.box_scales[in_batch];
          middle.by_L[d] *= points.box_scales[in_batch];
        }
    const auto   &sides = rules.grid.size_of(places.cells[i]);
    Tensor<1, nq> from_place; // Q - q
    for (unsigned int d = 0; d < dim; ++d)
      {
        from_place[d] = step.points.position(d)[p] + 0.5 * point.Su[d] -
                        places.positions[i][d];
        defect = std::max(defect, std::abs(from_place[d]) / sides[d]);
        if (has_boxes)
          from_place[dim + d] =
            middle.half_length[d] - places.half_lengths[i][d];
      }
    const MiddleBox<dim> *box = has_boxes ? &middle : nullptr;
    if (point.n_used == dim)
      return response_to<dim, dim>(point, from_place, box);
    if (point.n_used == dim + 1)
      return response_to<dim, dim + 1>(point, from_place, box);
    if constexpr (dim == 3)
      if (point.n_used == dim + 2)
        return response_to<dim, dim + 2>(point, from_place, box);
    return response_to<dim, 2 * dim>(point, from_place, box);
  }

  template <int dim>
  void
  MovingPlaces<dim>::set_force(const Points      &points,
                               const unsigned int at,
                               PointRows<dim>    &point) const
  {
    // the force of a point at a node is S_A w + T grad S_A, with
    // w = m 2/dt (Su/dt - v) - b; lumped mass sees u_A in place of Su
    const StepData<dim> &step   = points.step;
    const auto &[group, q]      = points.here.points[at];
    const unsigned int in_batch = points.here.at + at;
    const std::size_t  p        = group->first_point + q;
    const double       rate     = 2. / step.time_step;
    const double       m        = step.points.component(mass)[p];
    const double       inertia  = inertia_factor(step.time_step) * m;
    const double       volume   = points.volumes[in_batch];

    point.lumped      = rules.mapping.lumping * inertia;
    point.consistent  = inertia - point.lumped;
    point.on_diagonal = point.lumped + damping_of(inertia, 0.);
    point.least       = damping_of(0., inertia);
    for (unsigned int r = 0; r < dim * dim; ++r)
      for (unsigned int c = 0; c < dim * dim; ++c)
        point.tangent[r][c] = volume * points.batch.tangent[in_batch][r][c];
    for (unsigned int i = 0; i < dim; ++i)
      {
        point.w[i] = point.consistent * point.Su[i] -
                     rate * m * step.points.component(velocity + i)[p];
        if (!point_forces.empty())
          point.w[i] -= point_forces[dim * p + i];
        for (unsigned int J = 0; J < dim; ++J)
          point.T[i][J] = volume * points.batch.nominal_stress[in_batch][i][J];
      }
  }

  template <int dim>
  void
  MovingPlaces<dim>::find_motions(const StepData<dim>       &step,
                                  const Group               &group,
                                  const std::vector<double> &u,
                                  const bool                 with_gradients,
                                  std::vector<double>       &motion) const
  {
    const unsigned int *nodes     = step.start.active->nodes(group);
    const unsigned int  n_weights = with_gradients ? dim + 1 : 1;
    motion.assign(n_weights * dim * group.n_points, 0.);
    with_n_points(group.n_points, [&](const auto n) {
      for (unsigned int a = 0; a < group.n_nodes; ++a)
        for (unsigned int l = 0; l < n_weights; ++l)
          {
            const double *weight = l == 0
                                     ? step.stencils.value(group, a)
                                     : step.stencils.gradient(group, a, l - 1);
            for (unsigned int c = 0; c < dim; ++c)
              {
                const double u_a = u[unknown<dim>(nodes[a], c)];
                double      *sum = &motion[(l * dim + c) * n];
                for (unsigned int q = 0; q < n; ++q)
                  sum[q] += weight[q] * u_a;
              }
          }
    });
  }

  template <int dim>
  Places<dim>
  MovingPlaces<dim>::moved(const StepData<dim>       &step,
                           const std::vector<double> &increment) const
  {
    Places<dim>         result = places;
    std::vector<double> motion;
    for (const Group &group : step.stencils.groups)
      {
        find_motions(step, group, increment, /*with_gradients=*/true, motion);
        for (unsigned int q = 0; q < group.n_points; ++q)
          {
            const std::size_t p      = group.first_point + q;
            Tensor<1, nq>     change = responses[p].shift;
            for (unsigned int k = 0; k < (has_boxes ? nq : dim); ++k)
              for (unsigned int j = 0; j < dim; ++j)
                for (unsigned int l = 0; l <= dim; ++l)
                  change[k] += responses[p].by_motion[k][j][l] *
                               motion[(l * dim + j) * group.n_points + q];

            const std::size_t  i = step.stencils.order[p];
            dealii::Point<dim> x = places.positions[i];
            for (unsigned int d = 0; d < dim; ++d)
              {
                x[d] += change[d];
                if (!result.half_lengths.empty())
                  result.half_lengths[i][d] += change[dim + d];
              }
            result.positions[i] = rules.grid.clamped(x);
            result.cells[i]     = rules.grid.key_of(result.positions[i]);
          }
      }
    return result;
  }

  template class MovingPlaces<2>;
  template class MovingPlaces<3>;
} // namespace emmy
