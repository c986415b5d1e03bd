#include <emmy/effects/inertia.h>
#include <emmy/effects/moving_places.h>
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
  MovingPlaces<dim>::add(const Points               &points,
                         dealii::FullMatrix<double> &matrix)
  {
    const unsigned int  n     = points.group.n_nodes;
    const unsigned int *nodes = points.step.start.active->nodes(points.group);
    for (unsigned int c = 0; c < dim; ++c)
      for (unsigned int a = 0; a < n; ++a)
        work.u[c][a] = points.local_displacement[unknown<dim>(nodes[a], c)];
    work.matrix.reinit(dim * n, dim * n);
    for (unsigned int i = 0; i < points.batch.n_points; ++i)
      add_point(points, i);
    for (unsigned int row = 0; row < dim * n; ++row)
      for (unsigned int b = 0; b < n; ++b)
        for (unsigned int j = 0; j < dim; ++j)
          matrix(row, dim * b + j) += work.matrix(row, n * j + b);
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
    for (unsigned int a = 0; a < group.n_nodes; ++a)
      {
        work.weights[0][a] = stencils.value(group, a)[q];
        for (unsigned int d = 0; d < dim; ++d)
          work.weights[1 + d][a] = stencils.gradient(group, a, d)[q];
      }
    rules.shape_functions.differentiate(
      places, stencils.order[p], group, rules.grid, work.derivatives);
    const Motion here = motion(group.n_nodes);
    responses[p]      = response(points, in_batch, here);
    find_force_by_q(points, in_batch, here, responses[p].shift);
    add_to_matrix(points, in_batch, responses[p]);
  }

  template <int dim>
  typename MovingPlaces<dim>::Motion
  MovingPlaces<dim>::motion(const unsigned int n_nodes) const
  {
    Motion result;
    for (unsigned int a = 0; a < n_nodes; ++a)
      for (unsigned int c = 0; c < dim; ++c)
        {
          const double u = work.u[c][a];
          result.Su[c] += work.weights[0][a] * u;
          for (unsigned int k = 0; k < nq; ++k)
            {
              result.Su_by_q[k][c] += work.derivatives.value(k)[a] * u;
              for (unsigned int d = 0; d < dim; ++d)
                result.L_by_q[k][c][d] +=
                  work.derivatives.gradient(k, d)[a] * u;
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
    const bool has_box = rules.domain_update && !places.half_lengths.empty();
    MiddleBox<dim> box;
    if (has_box)
      box = rules.domain_update->middle(step.points,
                                        p,
                                        points.group.body,
                                        points.middle.from_start(in_batch));
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
        for (unsigned int k = 0; k < nq; ++k)
          {
            matrix[d][k] = (d == k ? 1. : 0.) - 0.5 * motion.Su_by_q[k][d];
            matrix[dim + d][k] = (dim + d == k ? 1. : 0.) -
                                 scalar_product(box.by_L[d], motion.L_by_q[k]);
          }
      }
    const Tensor<2, nq> inverse = inverse_of(matrix);
    Response            result;
    result.shift = inverse * from_place;
    for (unsigned int k = 0; k < nq; ++k)
      for (unsigned int j = 0; j < dim; ++j)
        {
          result.by_motion[k][j][0] = 0.5 * inverse[k][j];
          for (unsigned int e = 0; e < dim; ++e)
            for (unsigned int d = 0; d < dim; ++d)
              result.by_motion[k][j][1 + d] +=
                inverse[k][dim + e] * box.by_L[e][j][d];
        }
    return result;
  }

  template <int dim>
  void
  MovingPlaces<dim>::find_force_by_q(const Points        &points,
                                     const unsigned int   in_batch,
                                     const Motion        &motion,
                                     const Tensor<1, nq> &shift)
  {
    // the force of a point at a node is S_A w + T grad S_A, with
    // w = m 2/dt (Su/dt - v) - b; lumped mass sees u_A in place of Su
    const StepData<dim> &step = points.step;
    const std::size_t    p = points.group.first_point + points.first + in_batch;
    const unsigned int   n = points.group.n_nodes;
    const double         rate    = 2. / step.time_step;
    const double         m       = step.points.component(mass)[p];
    const double         inertia = 0.5 * rate * rate * m;
    const double         lumped  = rules.mapping.lumping * inertia;
    const double         volume  = points.volumes[in_batch];
    const auto           T = volume * points.batch.nominal_stress[in_batch];
    const auto          &tangent = points.batch.tangent[in_batch];
    Vector               w       = (inertia - lumped) * motion.Su;
    for (unsigned int c = 0; c < dim; ++c)
      {
        w[c] -= rate * m * step.points.component(velocity + c)[p];
        if (!point_forces.empty())
          w[c] -= point_forces[dim * p + c];
      }
    for (unsigned int k = 0; k < nq; ++k)
      for (unsigned int i = 0; i < dim; ++i)
        {
          const double inertia_by_q = (inertia - lumped) * motion.Su_by_q[k][i];
          Vector       T_by_q;
          for (unsigned int J = 0; J < dim; ++J)
            for (unsigned int c = 0; c < dim; ++c)
              for (unsigned int d = 0; d < dim; ++d)
                T_by_q[J] += volume * tangent[i * dim + J][c * dim + d] *
                             motion.L_by_q[k][c][d];
          std::array<const double *, dim> g_by_q;
          for (unsigned int J = 0; J < dim; ++J)
            g_by_q[J] = work.derivatives.gradient(k, J);
          const double *S_by_q = work.derivatives.value(k);
          for (unsigned int a = 0; a < n; ++a)
            {
              double sum = S_by_q[a] * (w[i] + lumped * work.u[i][a]) +
                           work.weights[0][a] * inertia_by_q;
              for (unsigned int J = 0; J < dim; ++J)
                sum +=
                  T[i][J] * g_by_q[J][a] + T_by_q[J] * work.weights[1 + J][a];
              work.force_by_q[k][i][a] = sum;
            }
        }
    const unsigned int *nodes = step.start.active->nodes(points.group);
    for (unsigned int a = 0; a < n; ++a)
      for (unsigned int i = 0; i < dim; ++i)
        {
          double sum = 0.;
          for (unsigned int k = 0; k < nq; ++k)
            sum += work.force_by_q[k][i][a] * shift[k];
          share[unknown<dim>(nodes[a], i)] += sum;
        }
  }

  template <int dim>
  void
  MovingPlaces<dim>::add_to_matrix(const Points      &points,
                                   const unsigned int in_batch,
                                   const Response    &response)
  {
    const StepData<dim> &step = points.step;
    const std::size_t    p = points.group.first_point + points.first + in_batch;
    const unsigned int   n = points.group.n_nodes;
    const double         inertia =
      inertia_factor(step.time_step) * step.points.component(mass)[p];
    const double lumped  = rules.mapping.lumping * inertia;
    const double volume  = points.volumes[in_batch];
    const auto  &tangent = points.batch.tangent[in_batch];
    // a copy, so that the compiler sees that the matrix is elsewhere
    const std::array<Row, dim + 1> weights = work.weights;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        {
          // the force at the nodes by (Su)_j and L_jd: where places stay a sum
          // of the weights, and of r,k as they follow
          std::array<Row, dim + 1> by_motion;
          for (unsigned int l = 0; l <= dim; ++l)
            {
              for (unsigned int a = 0; a < n; ++a)
                {
                  double sum = 0.;
                  if (l > 0)
                    for (unsigned int J = 0; J < dim; ++J)
                      sum += volume * tangent[i * dim + J][j * dim + l - 1] *
                             weights[1 + J][a];
                  else if (i == j)
                    sum = (inertia - lumped) * weights[0][a];
                  for (unsigned int k = 0; k < nq; ++k)
                    sum +=
                      response.by_motion[k][j][l] * work.force_by_q[k][i][a];
                  by_motion[l][a] = sum;
                }
            }
          for (unsigned int a = 0; a < n; ++a)
            {
              std::array<double, dim + 1> of_node;
              for (unsigned int l = 0; l <= dim; ++l)
                of_node[l] = by_motion[l][a];
              double *row = &work.matrix(dim * a + i, n * j);
              for (unsigned int b = 0; b < n; ++b)
                {
                  double sum = 0.;
                  for (unsigned int l = 0; l <= dim; ++l)
                    sum += of_node[l] * weights[l][b];
                  row[b] += sum;
                }
              if (i == j)
                row[a] += lumped * weights[0][a] +
                          damping_of(inertia * weights[0][a], inertia);
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
          for (unsigned int k = 0; k < nq; ++k)
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
