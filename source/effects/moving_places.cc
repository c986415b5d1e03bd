#include <emmy/effects/moving_places.h>

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
          for (unsigned int d = 0; d < dim; ++d)
            {
              double x = step.points.position(d)[p];
              for (unsigned int a = 0; a < group.n_nodes; ++a)
                x += 0.5 * step.stencils.value(group, a)[q] *
                     u[dim * nodes[a] + d];
              x -= places.positions[step.stencils.order[p]][d];
              defect =
                std::max(defect, std::abs(x) / rules.grid.cell_size()[d]);
            }
        }
  }

  template <int dim>
  void
  MovingPlaces<dim>::add(const StepData<dim>        &step,
                         const std::vector<double>  &local_displacement,
                         const Group                &group,
                         const unsigned int          first,
                         const StressBatch<dim>     &batch,
                         const Tensor<2, dim>       *from_start,
                         const double               *volumes,
                         dealii::FullMatrix<double> &stiffness)
  {
    for (unsigned int i = 0; i < batch.n_points; ++i)
      add_point(step,
                local_displacement,
                group,
                first + i,
                batch,
                i,
                from_start[i],
                volumes[i],
                stiffness);
  }

  template <int dim>
  void
  MovingPlaces<dim>::add_point(const StepData<dim>        &step,
                               const std::vector<double>  &u,
                               const Group                &group,
                               const unsigned int          q,
                               const StressBatch<dim>     &batch,
                               const unsigned int          in_batch,
                               const Tensor<2, dim>       &Z,
                               const double                volume,
                               dealii::FullMatrix<double> &stiffness)
  {
    const Stencils<dim> &stencils = step.stencils;
    const std::size_t    p        = group.first_point + q;
    const unsigned int  *nodes    = step.start.active->nodes(group);
    const unsigned int   n        = group.n_nodes;
    rules.shape_functions.differentiate(
      places, stencils.order[p], group, rules.grid, work.derivatives);
    const auto &S_by_q = work.derivatives.values;
    const auto &g_by_q = work.derivatives.gradients;

    Vector                         Su;
    std::array<Vector, nq>         Su_by_q;
    std::array<Tensor<2, dim>, nq> L_by_q;
    for (unsigned int a = 0; a < n; ++a)
      {
        Vector u_a;
        for (unsigned int c = 0; c < dim; ++c)
          u_a[c] = u[dim * nodes[a] + c];
        Su += stencils.value(group, a)[q] * u_a;
        for (unsigned int k = 0; k < nq; ++k)
          {
            Su_by_q[k] += S_by_q[a * nq + k] * u_a;
            L_by_q[k] += outer_product(u_a, g_by_q[a * nq + k]);
          }
      }

    // the force of a point at a node is S_A w + T grad S_A, with
    // w = m 2/dt (Su/dt - v) - b; lumped mass sees u_A in place of Su
    const double                   rate    = 2. / step.time_step;
    const double                   m       = step.points.component(mass)[p];
    const double                   inertia = 0.5 * rate * rate * m;
    const double                   lumped  = rules.mapping.lumping * inertia;
    Vector                         w       = inertia * Su;
    const auto                    &T       = batch.nominal_stress[in_batch];
    std::array<Tensor<2, dim>, nq> T_by_q;
    for (unsigned int c = 0; c < dim; ++c)
      {
        w[c] -= rate * m * step.points.component(velocity + c)[p];
        if (!point_forces.empty())
          w[c] -= point_forces[dim * p + c];
      }
    const auto &tangent = batch.tangent[in_batch];
    for (unsigned int k = 0; k < nq; ++k)
      for (unsigned int iJ = 0; iJ < dim * dim; ++iJ)
        {
          double sum = 0.;
          for (unsigned int mL = 0; mL < dim * dim; ++mL)
            sum += tangent[iJ][mL] * L_by_q[k][mL / dim][mL % dim];
          T_by_q[k][iJ / dim][iJ % dim] = volume * sum;
        }

    respond(step, group, p, Su, Su_by_q, L_by_q, Z);
    const Response     &response = responses[p];
    const Tensor<1, nq> shift    = response.inverse * response.defect;
    work.force_by_q.resize(n * nq);
    for (unsigned int a = 0; a < n; ++a)
      {
        const double S = stencils.value(group, a)[q];
        Vector       g, w_a = w;
        for (unsigned int c = 0; c < dim; ++c)
          {
            g[c] = stencils.gradient(group, a, c)[q];
            w_a[c] += lumped * (u[dim * nodes[a] + c] - Su[c]);
          }
        for (unsigned int k = 0; k < nq; ++k)
          {
            Vector &r = work.force_by_q[a * nq + k];
            r         = S_by_q[a * nq + k] * w_a +
                (S * (inertia - lumped)) * Su_by_q[k] +
                volume * (T * g_by_q[a * nq + k]) + T_by_q[k] * g;
            for (unsigned int c = 0; c < dim; ++c)
              share[dim * nodes[a] + c] += r[c] * shift[k];
          }
      }
    add_to_matrix(stencils, group, q, response, stiffness);
  }

  template <int dim>
  void
  MovingPlaces<dim>::respond(const StepData<dim>                  &step,
                             const Group                          &group,
                             const std::size_t                     p,
                             const Vector                         &Su,
                             const std::array<Vector, nq>         &Su_by_q,
                             const std::array<Tensor<2, dim>, nq> &L_by_q,
                             const Tensor<2, dim>                 &Z)
  {
    const std::size_t i        = step.stencils.order[p];
    Response         &response = responses[p];
    response                   = Response();
    const bool has_box = rules.domain_update && !places.half_lengths.empty();
    if (has_box)
      response.box = rules.domain_update->middle(step.points, p, group.body, Z);
    Tensor<2, nq> matrix;
    for (unsigned int d = 0; d < dim; ++d)
      {
        response.defect[d] =
          step.points.position(d)[p] + 0.5 * Su[d] - places.positions[i][d];
        defect =
          std::max(defect,
                   std::abs(response.defect[d]) / rules.grid.cell_size()[d]);
        if (has_box)
          response.defect[dim + d] =
            response.box.half_length[d] - places.half_lengths[i][d];
        for (unsigned int k = 0; k < nq; ++k)
          {
            matrix[d][k] = (d == k ? 1. : 0.) - 0.5 * Su_by_q[k][d];
            matrix[dim + d][k] =
              (dim + d == k ? 1. : 0.) -
              scalar_product(response.box.by_L[d], L_by_q[k]);
          }
      }
    response.inverse = inverse_of(matrix);
  }

  template <int dim>
  void
  MovingPlaces<dim>::add_to_matrix(const Stencils<dim>        &stencils,
                                   const Group                &group,
                                   const unsigned int          q,
                                   const Response             &response,
                                   dealii::FullMatrix<double> &stiffness)
  {
    // dq = (I - Q_q)^-1 Q_u du, with dx/du_b = S_b/2 I and
    // dl_d/du_b = by_L_d grad S_b
    const unsigned int n = group.n_nodes, n_columns = dim * n;
    work.q_by_u.resize(nq * n_columns);
    for (unsigned int b = 0; b < n; ++b)
      {
        const double half_S = 0.5 * stencils.value(group, b)[q];
        Vector       g;
        for (unsigned int c = 0; c < dim; ++c)
          g[c] = stencils.gradient(group, b, c)[q];
        std::array<Vector, dim> box_by_u;
        for (unsigned int d = 0; d < dim; ++d)
          box_by_u[d] = response.box.by_L[d] * g;
        for (unsigned int k = 0; k < nq; ++k)
          for (unsigned int j = 0; j < dim; ++j)
            {
              double sum = response.inverse[k][j] * half_S;
              for (unsigned int d = 0; d < dim; ++d)
                sum += response.inverse[k][dim + d] * box_by_u[d][j];
              work.q_by_u[k * n_columns + dim * b + j] = sum;
            }
      }
    for (unsigned int a = 0; a < n; ++a)
      for (unsigned int i = 0; i < dim; ++i)
        {
          std::array<double, nq> force_by_q;
          for (unsigned int k = 0; k < nq; ++k)
            force_by_q[k] = work.force_by_q[a * nq + k][i];
          double       *row    = &stiffness(dim * a + i, 0);
          const double *q_by_u = work.q_by_u.data();
          for (unsigned int c = 0; c < n_columns; ++c)
            {
              double sum = 0.;
              for (unsigned int k = 0; k < nq; ++k)
                sum += force_by_q[k] * q_by_u[k * n_columns + c];
              row[c] += sum;
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
          const unsigned int *nodes    = step.start.active->nodes(group);
          const std::size_t   p        = group.first_point + q;
          const Response     &response = responses[p];
          Tensor<1, nq>       change   = response.defect;
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            for (unsigned int d = 0; d < dim; ++d)
              change[d] += 0.5 * step.stencils.value(group, a)[q] *
                           increment[dim * nodes[a] + d];
          const auto dL =
            step.stencils.displacement_gradient(group, q, nodes, increment);
          for (unsigned int d = 0; d < dim; ++d)
            change[dim + d] += scalar_product(response.box.by_L[d], dL);
          change = response.inverse * change;

          const std::size_t  i = step.stencils.order[p];
          dealii::Point<dim> x = places.positions[i];
          for (unsigned int d = 0; d < dim; ++d)
            {
              x[d] += change[d];
              if (!result.half_lengths.empty())
                result.half_lengths[i][d] += change[dim + d];
            }
          result.positions[i] = rules.grid.clamped(x);
          result.cells[i]     = rules.grid.lattice(result.positions[i]);
        }
    return result;
  }

  template class MovingPlaces<2>;
  template class MovingPlaces<3>;
} // namespace emmy
