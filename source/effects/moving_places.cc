#include <emmy/effects/inertia.h>
#include <emmy/effects/moving_places.h>
#include <emmy/effects/node_lanes.h>
#include <emmy/effects/point_rows.h>
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
          std::swap(matrix[i], matrix[pivot]);
          std::swap(inverse[i], inverse[pivot]);
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
  } // namespace

  template <int dim>
  MovingPlaces<dim>::MovingPlaces(const PlaceRules<dim> &rules,
                                  const Places<dim>     &places)
    : rules(rules)
    , places(places)
    , mass(rules.layout["mass"])
    , velocity(rules.layout["velocity"])
    , responses(places.size())
    , n_used(rules.domain_update && !places.half_lengths.empty() ? nq : dim)
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
    for (const Group &group : step.stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const unsigned int *nodes = step.start.active->nodes(group);
          const std::size_t   p     = group.first_point + q;
          const auto         &sides =
            rules.grid.size_of(places.cells[step.stencils.order[p]]);
          for (unsigned int d = 0; d < dim; ++d)
            {
              double x = step.points.position(d)[p];
              for (unsigned int a = 0; a < group.n_nodes; ++a)
                x += 0.5 * step.stencils.value(group, a)[q] *
                     u[unknown<dim>(nodes[a], d)];
              x -= places.positions[step.stencils.order[p]][d];
              defect = std::max(defect, std::abs(x) / sides[d]);
            }
        }
  }

  template <int dim>
  void
  MovingPlaces<dim>::begin_group(const unsigned int n_nodes)
  {
    const auto reinit = [](Rows &rows, const unsigned int size) {
      rows.resize_fast(size);
      std::fill(rows.begin(), rows.end(), 0.);
    };
    const unsigned int n = padded<dim>(n_nodes);
    reinit(work.sum, dim * dim * n * n);
    if (work.n_nodes == n_nodes)
      return; // rows end with zeros already
    work.n_nodes  = n_nodes;
    work.n_padded = n;
    reinit(work.u, dim * n);
    reinit(work.weights, most_points_at_once * (dim + 1) * n);
    reinit(work.by_motion, most_points_at_once * dim * (dim + 1) * dim * n);
    reinit(work.weights_by_q, nq * (dim + 1) * n);
    reinit(work.force_by_q, nq * dim * n);
  }

  template <int dim>
  void
  MovingPlaces<dim>::add(const Points &points)
  {
    const unsigned int *nodes = points.step.start.active->nodes(points.group);
    for (unsigned int c = 0; c < dim; ++c)
      for (unsigned int a = 0; a < work.n_nodes; ++a)
        work.u[c * work.n_padded + a] =
          points.local_displacement[unknown<dim>(nodes[a], c)];
    work.n_points = 0;
    for (unsigned int i = 0; i < points.batch.n_points; ++i)
      {
        add_point(points, i);
        if (++work.n_points == most_points_at_once)
          add_up();
      }
    add_up();
  }

  template <int dim>
  void
  MovingPlaces<dim>::add_up()
  {
    add_products<dim>(work.n_points,
                      work.n_padded,
                      work.by_motion.data(),
                      work.weights.data(),
                      work.sum.data());
    work.n_points = 0;
  }

  template <int dim>
  ComponentBlocks
  MovingPlaces<dim>::blocks() const
  {
    const std::size_t n = work.n_padded;
    return {work.sum.data(), work.n_nodes, dim * n * n, n * n, n};
  }

  template <int dim>
  void
  MovingPlaces<dim>::add_point(const Points      &points,
                               const unsigned int in_batch)
  {
    const Stencils<dim> &stencils = points.step.stencils;
    const Group         &group    = points.group;
    const unsigned int   q        = points.first + in_batch;
    const std::size_t    p        = group.first_point + q;
    const unsigned int   n        = work.n_padded;
    double              *weights = &work.weights[work.n_points * (dim + 1) * n];
    for (unsigned int a = 0; a < work.n_nodes; ++a)
      {
        weights[a] = stencils.value(group, a)[q];
        for (unsigned int d = 0; d < dim; ++d)
          weights[(1 + d) * n + a] = stencils.gradient(group, a, d)[q];
      }
    rules.shape_functions.differentiate(
      places, stencils.order[p], group, rules.grid, work.derivatives);
    for (unsigned int k = 0; k < n_used; ++k)
      for (unsigned int l = 0; l <= dim; ++l)
        std::copy_n(l == 0 ? work.derivatives.value(k)
                           : work.derivatives.gradient(k, l - 1),
                    work.n_nodes,
                    &work.weights_by_q[(k * (dim + 1) + l) * n]);
    const Motion here = motion();
    responses[p]      = response(points, in_batch, here);
    find_rows(points, in_batch, here, responses[p]);
  }

  template <int dim>
  typename MovingPlaces<dim>::Motion
  MovingPlaces<dim>::motion() const
  {
    const unsigned int n       = work.n_padded;
    const double      *weights = &work.weights[work.n_points * (dim + 1) * n];
    const auto         sum     = [&](const double *row, const unsigned int c) {
      const double *u      = &work.u[c * n];
      double        result = 0.;
      for (unsigned int a = 0; a < work.n_nodes; ++a)
        result += row[a] * u[a];
      return result;
    };
    Motion result;
    for (unsigned int c = 0; c < dim; ++c)
      {
        result.Su[c] = sum(weights, c);
        for (unsigned int k = 0; k < n_used; ++k)
          {
            const double *by_q   = &work.weights_by_q[k * (dim + 1) * n];
            result.Su_by_q[k][c] = sum(by_q, c);
            for (unsigned int d = 0; d < dim; ++d)
              result.L_by_q[k][c][d] = sum(by_q + (1 + d) * n, c);
          }
      }
    return result;
  }

  template <int dim>
  typename MovingPlaces<dim>::Response
  MovingPlaces<dim>::response(const Points      &points,
                              const unsigned int in_batch,
                              const Motion      &motion)
  {
    const StepData<dim> &step = points.step;
    const std::size_t    p = points.group.first_point + points.first + in_batch;
    const std::size_t    i = step.stencils.order[p];
    const bool           has_box = n_used > dim;
    MiddleBox<dim>       box;
    if (has_box)
      box = rules.domain_update->middle(step.points,
                                        p,
                                        points.group.body,
                                        points.middle.from_start(in_batch));
    if (has_box && points.box_scales)
      for (unsigned int d = 0; d < dim; ++d)
        {
          box.half_length[d] *= points.box_scales[in_batch];
          box.by_L[d] *= points.box_scales[in_batch];
        }
    const auto   &sides = rules.grid.size_of(places.cells[i]);
    Tensor<1, nq> from_place; // Q - q
    Tensor<2, nq> matrix;     // I - Q_q
    for (unsigned int d = 0; d < dim; ++d)
      {
        from_place[d] = step.points.position(d)[p] + 0.5 * motion.Su[d] -
                        places.positions[i][d];
        defect = std::max(defect, std::abs(from_place[d]) / sides[d]);
        if (has_box)
          from_place[dim + d] = box.half_length[d] - places.half_lengths[i][d];
        for (unsigned int k = 0; k < n_used; ++k)
          {
            matrix[d][k] = (d == k ? 1. : 0.) - 0.5 * motion.Su_by_q[k][d];
            matrix[dim + d][k] = (dim + d == k ? 1. : 0.) -
                                 scalar_product(box.by_L[d], motion.L_by_q[k]);
          }
      }
    Tensor<2, nq> inverse;
    if (has_box)
      inverse = inverse_of(matrix);
    else
      {
        Tensor<2, dim> of_position;
        for (unsigned int d = 0; d < dim; ++d)
          for (unsigned int k = 0; k < dim; ++k)
            of_position[d][k] = matrix[d][k];
        of_position = inverse_of(of_position);
        for (unsigned int d = 0; d < dim; ++d)
          for (unsigned int k = 0; k < dim; ++k)
            inverse[d][k] = of_position[d][k];
      }
    Response result;
    result.shift = inverse * from_place;
    for (unsigned int k = 0; k < n_used; ++k)
      for (unsigned int j = 0; j < dim; ++j)
        {
          result.by_motion[k][j][0] = 0.5 * inverse[k][j];
          for (unsigned int e = 0; has_box && e < dim; ++e)
            for (unsigned int d = 0; d < dim; ++d)
              result.by_motion[k][j][1 + d] +=
                inverse[k][dim + e] * box.by_L[e][j][d];
        }
    return result;
  }

  template <int dim>
  void
  MovingPlaces<dim>::find_rows(const Points      &points,
                               const unsigned int in_batch,
                               const Motion      &motion,
                               const Response    &response)
  {
    // the force of a point at a node is S_A w + T grad S_A, with
    // w = m 2/dt (Su/dt - v) - b; lumped mass sees u_A in place of Su
    const StepData<dim> &step = points.step;
    const std::size_t    p = points.group.first_point + points.first + in_batch;
    const unsigned int   n = work.n_padded;
    const double         rate    = 2. / step.time_step;
    const double         m       = step.points.component(mass)[p];
    const double         inertia = inertia_factor(step.time_step) * m;
    const double         volume  = points.volumes[in_batch];

    PointRows<dim> point;
    point.n_padded     = n;
    point.n_used       = n_used;
    point.u            = work.u.data();
    point.weights      = &work.weights[work.n_points * (dim + 1) * n];
    point.weights_by_q = work.weights_by_q.data();
    point.force_by_q   = work.force_by_q.data();
    point.by_motion =
      &work.by_motion[work.n_points * dim * (dim + 1) * dim * n];
    point.lumped     = rules.mapping.lumping * inertia;
    point.consistent = inertia - point.lumped;
    for (unsigned int r = 0; r < dim * dim; ++r)
      for (unsigned int c = 0; c < dim * dim; ++c)
        point.tangent[r][c] = volume * points.batch.tangent[in_batch][r][c];
    for (unsigned int i = 0; i < dim; ++i)
      {
        point.w[i] = point.consistent * motion.Su[i] -
                     rate * m * step.points.component(velocity + i)[p];
        if (!point_forces.empty())
          point.w[i] -= point_forces[dim * p + i];
        for (unsigned int J = 0; J < dim; ++J)
          point.T[i][J] = volume * points.batch.nominal_stress[in_batch][i][J];
      }
    for (unsigned int k = 0; k < n_used; ++k)
      for (unsigned int i = 0; i < dim; ++i)
        {
          point.w_by_q[k][i] = point.consistent * motion.Su_by_q[k][i];
          for (unsigned int J = 0; J < dim; ++J)
            {
              double sum = 0.;
              for (unsigned int c = 0; c < dim; ++c)
                for (unsigned int d = 0; d < dim; ++d)
                  sum += point.tangent[i * dim + J][c * dim + d] *
                         motion.L_by_q[k][c][d];
              point.T_by_q[k][i][J] = sum;
            }
          for (unsigned int l = 0; l <= dim; ++l)
            point.by_motion_of_q[k][i][l] = response.by_motion[k][i][l];
        }
    point.find_force_by_q();
    point.find_by_motion();

    const unsigned int *nodes = step.start.active->nodes(points.group);
    for (unsigned int a = 0; a < work.n_nodes; ++a)
      {
        const double of_node = point.lumped * point.weights[a] +
                               damping_of(inertia * point.weights[a], inertia);
        for (unsigned int i = 0; i < dim; ++i)
          {
            double sum = 0.;
            for (unsigned int k = 0; k < n_used; ++k)
              sum += work.force_by_q[(k * dim + i) * n + a] * response.shift[k];
            share[unknown<dim>(nodes[a], i)] += sum;
            work.sum[((i * dim + i) * n + a) * n + a] += of_node;
          }
      }
  }

  template <int dim>
  Places<dim>
  MovingPlaces<dim>::moved(const StepData<dim>       &step,
                           const std::vector<double> &increment) const
  {
    Places<dim> result = places;
    for (const Group &group : step.stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const unsigned int *nodes  = step.start.active->nodes(group);
          const std::size_t   p      = group.first_point + q;
          Tensor<1, nq>       change = responses[p].shift;
          Vector              Su;
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            for (unsigned int d = 0; d < dim; ++d)
              Su[d] += step.stencils.value(group, a)[q] *
                       increment[unknown<dim>(nodes[a], d)];
          const auto L =
            step.stencils.displacement_gradient(group, q, nodes, increment);
          for (unsigned int k = 0; k < n_used; ++k)
            for (unsigned int j = 0; j < dim; ++j)
              {
                const auto &by_motion = responses[p].by_motion[k][j];
                change[k] += by_motion[0] * Su[j];
                for (unsigned int d = 0; d < dim; ++d)
                  change[k] += by_motion[1 + d] * L[j][d];
              }

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
    return result;
  }

  template class MovingPlaces<2>;
  template class MovingPlaces<3>;
} // namespace emmy
