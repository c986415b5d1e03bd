#include <emmy/effects/corner_forces.h>
#include <emmy/effects/moving_places.h>

#include <cmath>

namespace emmy
{
  using dealii::Tensor;

  template <int dim>
  Field
  deformation_gradient_field()
  {
    std::vector<double> unit(dim * dim, 0.);
    for (unsigned int d = 0; d < dim; ++d)
      unit[dim * d + d] = 1.;
    return {"deformation_gradient",
            Field::Kind::tensor,
            "1",
            "deformation gradient F since the start of the run",
            unit};
  }

  template <int dim>
  std::vector<ParticleCorners<dim>>
  corners_of_bodies(const Effects<dim> &effects)
  {
    std::vector<ParticleCorners<dim>> result;
    for (unsigned int b = 0; b < effects.half_length_of_body.size(); ++b)
      {
        const auto &l      = effects.half_length_of_body[b];
        double      volume = 1.;
        for (unsigned int d = 0; d < dim; ++d)
          volume *= 2. * l[d];
        const double s = std::pow(volume, 1. / dim);
        result.push_back({l,
                          s,
                          effects.material_of_body[b]->p_wave_modulus() *
                            (dim == 3 ? s : 1.) / (1u << (dim - 1))});
      }
    return result;
  }

  template <int dim>
  Tensor<2, dim>
  tensor_field(const PointArrays<dim> &points,
               const unsigned int      first,
               const std::size_t       p)
  {
    Tensor<2, dim> result;
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int j = 0; j < dim; ++j)
        result[i][j] = points.component(first + dim * i + j)[p];
    return result;
  }

  template <int dim>
  CornerMotion<dim>
  corner_motion(const StepData<dim>                 &step,
                const typename Stencils<dim>::Group &group,
                const unsigned int                   q,
                const std::vector<double>           &u,
                const ParticleCorners<dim>          &corners,
                const unsigned int                   deformation_gradient)
  {
    const unsigned int *nodes = step.start.active->nodes(group);
    CornerMotion<dim>   result;
    result.p       = group.first_point + q;
    result.corners = &corners;
    result.place   = step.points.point(result.p);
    for (unsigned int a = 0; a < group.n_nodes; ++a)
      for (unsigned int c = 0; c < dim; ++c)
        result.way[c] +=
          step.stencils.value(group, a)[q] * u[unknown<dim>(nodes[a], c)];
    result.gradient = step.stencils.displacement_gradient(group, q, nodes, u);
    result.F_old    = tensor_field(step.points, deformation_gradient, result.p);
    result.find_arms(step.stencils.at_middle);
    return result;
  }

  template <int dim>
  void
  CornerMotion<dim>::find_arms(const bool at_middle)
  {
    F = F_old;
    if (!at_middle)
      return;
    Tensor<2, dim> from_start = -0.5 * gradient;
    for (unsigned int d = 0; d < dim; ++d)
      from_start[d][d] += 1.;
    Z = invert(from_start);
    F = Z * F_old;
  }

  template <int dim>
  FollowedMotion<dim>
  followed_motion(const StepData<dim>                 &step,
                  const typename Stencils<dim>::Group &group,
                  const unsigned int                   q,
                  const std::vector<double>           &u)
  {
    FollowedMotion<dim> result{};
    for (unsigned int row = 0; row < result.by_nodes.size(); ++row)
      result.by_nodes[row][row] = 1.;
    if (!step.moving)
      return result;
    const unsigned int   *nodes = step.start.active->nodes(group);
    PlaceDerivatives<dim> by_place;
    const auto &response = step.moving->response_of(group.first_point + q);
    step.moving->differentiate(step, group, q, by_place);
    for (unsigned int k = 0; k < PlaceDerivatives<dim>::n; ++k)
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int l = 0; l <= dim; ++l)
          {
            double sum = 0.; // z,k
            for (unsigned int a = 0; a < group.n_nodes; ++a)
              sum += (l == 0 ? by_place.value(k)[a]
                             : by_place.gradient(k, l - 1)[a]) *
                     u[unknown<dim>(nodes[a], i)];
            const unsigned int row = (dim + 1) * i + l;
            result.shift[row] += sum * response.shift[k];
            for (unsigned int j = 0; j < dim; ++j)
              for (unsigned int m = 0; m <= dim; ++m)
                result.by_nodes[row][(dim + 1) * j + m] +=
                  sum * response.by_motion[k][j][m];
          }
    return result;
  }

  namespace
  {
    /** That of a place that stays. */
    template <int dim>
    FollowedMotion<dim>
    unmoved()
    {
      FollowedMotion<dim> result{};
      for (unsigned int row = 0; row < result.by_nodes.size(); ++row)
        result.by_nodes[row][row] = 1.;
      return result;
    }

    /** Add z,k dq_k of a coordinate of the place. */
    template <int dim>
    void
    add_along(const PointMotion<dim> &z,
              const double            shift,
              const PointMotion<dim> &by,
              FollowedMotion<dim>    &result)
    {
      for (unsigned int row = 0; row < z.size(); ++row)
        {
          result.shift[row] += z[row] * shift;
          for (unsigned int column = 0; column < z.size(); ++column)
            result.by_nodes[row][column] += z[row] * by[column];
        }
    }
  } // namespace

  template <int dim>
  CornerForces<dim>::CornerForces(const StepData<dim>       &step,
                                  const std::vector<double> &displacement,
                                  Matrix                    *jacobian)
    : step(step)
    , displacement(displacement)
    , jacobian(jacobian)
    , nodal_force(dim * step.start.active->n_local_nodes())
    , share(jacobian && step.moving ? nodal_force.size() : 0)
  {}

  template <int dim>
  void
  CornerForces<dim>::add(const CornerMotion<dim> &particle,
                         const Tensor<1, dim>    &a,
                         const Tensor<1, dim>    &force,
                         const Tensor<2, dim>    &derivative)
  {
    acts                   = true;
    const Tensor<2, dim> Z = particle.Z;
    const Tensor<2, dim> by_gradient =
      derivative + 0.5 * (derivative * (particle.gradient * Z));
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int l = 0; l <= dim; ++l)
        {
          const double       weight = l == 0 ? 1. : a[l - 1];
          const unsigned int row    = (dim + 1) * i + l;
          value[row] += weight * force[i];
          for (unsigned int j = 0; j < dim; ++j)
            {
              double *entry = &by_motion[row][(dim + 1) * j];
              entry[0] += weight * derivative[i][j];
              for (unsigned int m = 0; m < dim; ++m)
                {
                  entry[1 + m] += weight * by_gradient[i][j] * a[m];
                  if (l > 0) // the arm turns
                    entry[1 + m] += 0.5 * force[i] * Z[l - 1][j] * a[m];
                }
            }
        }
  }

  template <int dim>
  void
  CornerForces<dim>::add(const PointMotion<dim> &forces,
                         const std::array<PointMotion<dim>, dim *(dim + 1)> &by)
  {
    acts = true;
    for (unsigned int row = 0; row < n_motion; ++row)
      {
        value[row] += forces[row];
        for (unsigned int column = 0; column < n_motion; ++column)
          by_motion[row][column] += by[row][column];
      }
  }

  template <int dim>
  void
  CornerForces<dim>::follow_places(const Group         &group,
                                   const unsigned int   q,
                                   FollowedMotion<dim> *followed)
  {
    if (followed)
      *followed = unmoved<dim>();
    const unsigned int *nodes = step.start.active->nodes(group);
    const auto &response      = step.moving->response_of(group.first_point + q);
    step.moving->differentiate(step, group, q, by_place);
    const auto where_they_stay = by_motion;
    Motion     moved{}; // E z,k shift_k
    for (unsigned int k = 0; k < PlaceDerivatives<dim>::n; ++k)
      {
        std::array<const double *, dim + 1> W{{by_place.value(k)}}; // W,k
        for (unsigned int d = 0; d < dim; ++d)
          W[1 + d] = by_place.gradient(k, d);
        const double shift = response.shift[k];
        Motion       z{}, by{}; // z,k and dq_k/dz
        for (unsigned int j = 0; j < dim; ++j)
          for (unsigned int m = 0; m <= dim; ++m)
            by[(dim + 1) * j + m] = response.by_motion[k][j][m];
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          for (unsigned int j = 0; j < dim; ++j)
            {
              const double u = displacement[unknown<dim>(nodes[a], j)];
              for (unsigned int m = 0; m <= dim; ++m)
                z[(dim + 1) * j + m] += W[m][a] * u;
            }
        if (followed)
          add_along<dim>(z, shift, by, *followed);
        for (unsigned int row = 0; row < n_motion; ++row)
          {
            double sum = 0.; // E z,k
            for (unsigned int column = 0; column < n_motion; ++column)
              sum += where_they_stay[row][column] * z[column];
            moved[row] += sum * shift;
            for (unsigned int column = 0; column < n_motion; ++column)
              by_motion[row][column] += sum * by[column];
          }
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          for (unsigned int i = 0; i < dim; ++i)
            {
              double sum = 0.; // W,k G
              for (unsigned int l = 0; l <= dim; ++l)
                sum += W[l][a] * value[(dim + 1) * i + l];
              share[unknown<dim>(nodes[a], i)] -= sum * shift;
              Motion &row = along[dim * a + i];
              for (unsigned int column = 0; column < n_motion; ++column)
                row[column] += sum * by[column];
            }
      }
    for (unsigned int a = 0; a < group.n_nodes; ++a)
      for (unsigned int i = 0; i < dim; ++i)
        {
          double sum = step.stencils.value(group, a)[q] * moved[(dim + 1) * i];
          for (unsigned int d = 0; d < dim; ++d)
            sum += step.stencils.gradient(group, a, d)[q] *
                   moved[(dim + 1) * i + 1 + d];
          share[unknown<dim>(nodes[a], i)] -= sum;
        }
  }

  template <int dim>
  void
  CornerForces<dim>::finish(const Group         &group,
                            const unsigned int   q,
                            FollowedMotion<dim> *followed)
  {
    if (!acts)
      return;
    const unsigned int  n     = group.n_nodes;
    const unsigned int *nodes = step.start.active->nodes(group);
    std::vector<std::array<double, dim + 1>> weights(n);
    for (unsigned int a = 0; a < n; ++a)
      {
        weights[a][0] = step.stencils.value(group, a)[q];
        for (unsigned int d = 0; d < dim; ++d)
          weights[a][1 + d] = step.stencils.gradient(group, a, d)[q];
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int l = 0; l <= dim; ++l)
            nodal_force[unknown<dim>(nodes[a], i)] -=
              weights[a][l] * value[(dim + 1) * i + l];
      }
    if (jacobian)
      {
        if (!has_matrix)
          matrix.reinit(dim * n, dim * n);
        has_matrix = true;
        along.assign(dim * n, Motion{});
        if (step.moving)
          follow_places(group, q, followed);
        for (unsigned int a = 0; a < n; ++a)
          for (unsigned int i = 0; i < dim; ++i)
            {
              Motion &row = along[dim * a + i];
              for (unsigned int l = 0; l <= dim; ++l)
                for (unsigned int column = 0; column < n_motion; ++column)
                  row[column] +=
                    weights[a][l] * by_motion[(dim + 1) * i + l][column];
              for (unsigned int b = 0; b < n; ++b)
                for (unsigned int j = 0; j < dim; ++j)
                  for (unsigned int m = 0; m <= dim; ++m)
                    matrix(dim * a + i, dim * b + j) -=
                      row[(dim + 1) * j + m] * weights[b][m];
            }
      }
    acts      = false;
    value     = {};
    by_motion = {};
  }

  template <int dim>
  void
  CornerForces<dim>::finish(const Group &group)
  {
    if (has_matrix)
      step.start.active->graph().add(step.start.active->nodes(group),
                                     matrix,
                                     *jacobian);
    has_matrix = false;
  }

  template <int dim>
  void
  CornerForces<dim>::finish(Vector &force)
  {
    step.start.active->add(nodal_force, force);
    if (jacobian && step.moving)
      step.moving->add_to_share(share);
  }

#define INSTANTIATE(dim)                                                        \
  template Field                             deformation_gradient_field<dim>(); \
  template std::vector<ParticleCorners<dim>> corners_of_bodies<dim>(            \
    const Effects<dim> &);                                                      \
  template FollowedMotion<dim> followed_motion<dim>(                            \
    const StepData<dim> &,                                                      \
    const Stencils<dim>::Group &,                                               \
    const unsigned int,                                                         \
    const std::vector<double> &);                                               \
  template struct CornerMotion<dim>;                                            \
  template class CornerForces<dim>;                                             \
  template Tensor<2, dim>    tensor_field<dim>(const PointArrays<dim> &,        \
                                            const unsigned int,              \
                                            const std::size_t);              \
  template CornerMotion<dim> corner_motion<dim>(const StepData<dim> &,          \
                                                const Stencils<dim>::Group &,   \
                                                const unsigned int,             \
                                                const std::vector<double> &,    \
                                                const ParticleCorners<dim> &,   \
                                                const unsigned int);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
