#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/math/spectral.h>
#include <emmy/transfer/domain_update.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  namespace
  {
    template <int dim>
    using Group = typename Stencils<dim>::Group;

    /** det F of a point, from its total b. */
    template <int dim>
    double
    volume_ratio(const PointArrays<dim> &trial,
                 const unsigned int      left_cauchy_green_less_unit,
                 const std::size_t       p)
    {
      return std::sqrt(
        1. +
        mandel::determinant_less_one<dim>(
          trial.template get<n_mandel<dim>>(left_cauchy_green_less_unit, p)));
    }

    /** l = l0 (det F)^(1/dim). */
    template <int dim>
    class VolumeUpdate : public DomainUpdate<dim>
    {
    public:
      VolumeUpdate(std::vector<dealii::Tensor<1, dim>> initial,
                   const FieldLayout                  &layout)
        : initial(std::move(initial))
        , half_length(layout["half_length"])
        , left_cauchy_green_less_unit(layout["left_cauchy_green_less_unit"])
      {}

      void
      operator()(const Stencils<dim> &stencils,
                 const PointArrays<dim> &,
                 const ActiveGrid<dim> &,
                 const std::vector<double> &,
                 PointArrays<dim> &trial) const override
      {
        for (const auto &group : stencils.groups)
          for (unsigned int q = 0; q < group.n_points; ++q)
            {
              const std::size_t p     = group.first_point + q;
              const double      scale = std::pow(
                volume_ratio<dim>(trial, left_cauchy_green_less_unit, p),
                1. / dim);
              trial.set(half_length, p, scale * initial[group.body]);
            }
      }

      MiddleBox<dim>
      middle(const PointArrays<dim>       &states,
             const std::size_t             p,
             const unsigned int            body,
             const dealii::Tensor<2, dim> &Z) const override
      {
        MiddleBox<dim> box;
        box.half_length =
          std::pow(determinant(Z) *
                     volume_ratio<dim>(states, left_cauchy_green_less_unit, p),
                   1. / dim) *
          initial[body];
        // d ln det F_mid = tr(Z dL)/2
        for (unsigned int d = 0; d < dim; ++d)
          box.by_L[d] = 0.5 / dim * box.half_length[d] * transpose(Z);
        return box;
      }

    private:
      const std::vector<dealii::Tensor<1, dim>> initial; // of each body
      const unsigned int half_length, left_cauchy_green_less_unit;
    };

    /** From F: l_i = l0_i F_ii or l0_i U_ii. Also keeps F. */
    template <int dim>
    class GradientUpdate : public DomainUpdate<dim>
    {
    public:
      GradientUpdate(const bool                          is_stretch,
                     std::vector<dealii::Tensor<1, dim>> initial,
                     FieldLayout                        &layout)
        : is_stretch(is_stretch)
        , initial(std::move(initial))
        , half_length(layout["half_length"])
        , deformation_gradient(
            layout.add({"deformation_gradient",
                        Field::Kind::tensor,
                        "1",
                        "deformation gradient F since the start of the run",
                        unit()}))
      {}

      void
      operator()(const Stencils<dim>       &stencils,
                 const PointArrays<dim>    &points,
                 const ActiveGrid<dim>     &active,
                 const std::vector<double> &displacement,
                 PointArrays<dim>          &trial) const override
      {
        for (const auto &group : stencils.groups)
          for (unsigned int q = 0; q < group.n_points; ++q)
            {
              const std::size_t            p     = group.first_point + q;
              const dealii::Tensor<2, dim> F_old = deformation(points, p);
              const dealii::Tensor<2, dim> H     = stencils.step_gradient(
                group, q, active.nodes(group), displacement);
              const dealii::Tensor<2, dim> F = F_old + H * F_old;
              for (unsigned int i = 0; i < dim; ++i)
                for (unsigned int j = 0; j < dim; ++j)
                  trial.component(deformation_gradient + dim * i + j)[p] =
                    F[i][j];
              dealii::Tensor<1, dim> diagonal;
              if (is_stretch)
                {
                  const auto C = right_cauchy_green(F);
                  for (unsigned int d = 0; d < dim; ++d)
                    diagonal[d] = stretch(C, d);
                }
              else
                for (unsigned int d = 0; d < dim; ++d)
                  diagonal[d] = F[d][d];
              for (unsigned int d = 0; d < dim; ++d)
                trial.component(half_length + d)[p] =
                  initial[group.body][d] * diagonal[d];
            }
      }

      MiddleBox<dim>
      middle(const PointArrays<dim>       &states,
             const std::size_t             p,
             const unsigned int            body,
             const dealii::Tensor<2, dim> &Z) const override
      {
        const dealii::Tensor<2, dim> F = Z * deformation(states, p);
        MiddleBox<dim>               box;
        if (is_stretch)
          set_stretches(F, Z, box);
        else
          for (unsigned int d = 0; d < dim; ++d)
            {
              box.half_length[d] = F[d][d];
              box.by_L[d]        = diagonal_by_L(F, Z, d);
            }
        for (unsigned int d = 0; d < dim; ++d)
          {
            box.half_length[d] *= initial[body][d];
            box.by_L[d] *= initial[body][d];
          }
        return box;
      }

    private:
      /** F at t. */
      dealii::Tensor<2, dim>
      deformation(const PointArrays<dim> &states, const std::size_t p) const
      {
        dealii::Tensor<2, dim> F;
        for (unsigned int i = 0; i < dim; ++i)
          for (unsigned int j = 0; j < dim; ++j)
            F[i][j] = states.component(deformation_gradient + dim * i + j)[p];
        return F;
      }

      /** dF_dd/dL, with dF = Z dL F/2. */
      static dealii::Tensor<2, dim>
      diagonal_by_L(const dealii::Tensor<2, dim> &F,
                    const dealii::Tensor<2, dim> &Z,
                    const unsigned int            d)
      {
        dealii::Tensor<2, dim> result;
        for (unsigned int a = 0; a < dim; ++a)
          for (unsigned int b = 0; b < dim; ++b)
            result[a][b] = 0.5 * Z[d][a] * F[b][d];
        return result;
      }

      /**
       * U_dd and dU_dd/dL in the plane, where U = (C + J I) / t with
       * t = sqrt(tr C + 2 J) and J = det F > 0 (Hoger and Carlson 1984).
       */
      static void
      set_stretches(const dealii::Tensor<2, 2> &F,
                    const dealii::Tensor<2, 2> &Z,
                    MiddleBox<2>               &box)
      {
        const dealii::Tensor<2, 2> z = transpose(Z) * F;
        const double               J = determinant(F);
        const double               t = std::sqrt(F.norm_square() + 2. * J);
        for (unsigned int d = 0; d < 2; ++d)
          box.half_length[d] = (F[0][d] * F[0][d] + F[1][d] * F[1][d] + J) / t;
        for (unsigned int a = 0; a < 2; ++a)
          for (unsigned int b = 0; b < 2; ++b)
            {
              const double dJ   = 0.5 * J * Z[b][a];
              const double dC[] = {z[a][0] * F[b][0], z[a][1] * F[b][1]};
              const double dt   = (0.5 * (dC[0] + dC[1]) + dJ) / t;
              for (unsigned int d = 0; d < 2; ++d)
                box.by_L[d][a][b] = (dC[d] + dJ - box.half_length[d] * dt) / t;
            }
      }

      /**
       * U_dd and dU_dd/dL: with eigenvectors v_i of F^T F and stretches s_i,
       * dU_dd = sum_ij v_id v_jd v_i.dC v_j / (s_i + s_j).
       */
      static void
      set_stretches(const dealii::Tensor<2, 3> &F,
                    const dealii::Tensor<2, 3> &Z,
                    MiddleBox<3>               &box)
      {
        const auto C = spectral_decomposition<3>(
          mandel::symmetric_part<3>(transpose(F) * F, 1.));
        const dealii::Tensor<2, 3> f = F * C.vectors;
        const dealii::Tensor<2, 3> z = transpose(Z) * f;
        dealii::Tensor<1, 3>       s;
        dealii::Tensor<2, 3>       weight; // 1 / (s_i + s_j)
        for (unsigned int i = 0; i < 3; ++i)
          {
            s[i] = std::sqrt(C.values[i]);
            for (unsigned int j = 0; j <= i; ++j)
              weight[i][j] = weight[j][i] = 1. / (s[i] + s[j]);
          }
        for (unsigned int d = 0; d < 3; ++d)
          {
            const dealii::Tensor<1, 3> v = C.vectors[d];
            for (unsigned int i = 0; i < 3; ++i)
              {
                box.half_length[d] += s[i] * v[i] * v[i];
                dealii::Tensor<1, 3> sum;
                for (unsigned int j = 0; j < 3; ++j)
                  for (unsigned int a = 0; a < 3; ++a)
                    sum[a] += v[j] * weight[i][j] * z[a][j];
                for (unsigned int a = 0; a < 3; ++a)
                  for (unsigned int b = 0; b < 3; ++b)
                    box.by_L[d][a][b] += v[i] * sum[a] * f[b][i];
              }
          }
      }

      static std::vector<double>
      unit()
      {
        std::vector<double> F(dim * dim, 0.);
        for (unsigned int d = 0; d < dim; ++d)
          F[dim * d + d] = 1.;
        return F;
      }

      /** C = F^T F. */
      static SpectralDecomposition<dim>
      right_cauchy_green(const dealii::Tensor<2, dim> &F)
      {
        return spectral_decomposition<dim>(
          mandel::symmetric_part<dim>(transpose(F) * F, 1.));
      }

      /** U_dd of the right stretch U = sqrt(C). */
      static double
      stretch(const SpectralDecomposition<dim> &C, const unsigned int d)
      {
        double result = 0.;
        for (unsigned int i = 0; i < dim; ++i)
          result += std::sqrt(C.values[i]) * C.vectors[d][i] * C.vectors[d][i];
        return result;
      }

      const bool                                is_stretch;
      const std::vector<dealii::Tensor<1, dim>> initial;
      const unsigned int half_length, deformation_gradient;
    };

    /** From the motion of the domain's corners. */
    template <int dim>
    class CornerUpdate : public DomainUpdate<dim>
    {
    public:
      CornerUpdate(std::vector<dealii::Tensor<1, dim>> initial,
                   const BackgroundGrid<dim>          &grid,
                   const FieldLayout                  &layout)
        : initial(std::move(initial))
        , grid(grid)
        , half_length(layout["half_length"])
        , left_cauchy_green_less_unit(layout["left_cauchy_green_less_unit"])
      {}

      void
      operator()(const Stencils<dim>       &stencils,
                 const PointArrays<dim>    &points,
                 const ActiveGrid<dim>     &active,
                 const std::vector<double> &displacement,
                 PointArrays<dim>          &trial) const override
      {
        for (const auto &group : stencils.groups)
          for (unsigned int q = 0; q < group.n_points; ++q)
            {
              const std::size_t p = group.first_point + q;
              // as the shape functions use it: at most a cell
              const auto l = points.template get<dim>(half_length, p);
              const dealii::Point<dim> center =
                stencils.at_middle ? place(stencils, group, q, active)
                                   : points.point(p);
              dealii::Tensor<1, dim> used, lowest, highest;
              for (unsigned int d = 0; d < dim; ++d)
                used[d] = std::min(l[d], grid.size_at(center)[d]);
              for (unsigned int corner = 0; corner < (1u << dim); ++corner)
                {
                  dealii::Point<dim> x = center;
                  for (unsigned int d = 0; d < dim; ++d)
                    x[d] += (corner >> d) & 1 ? used[d] : -used[d];
                  // the grid ends at its edge, the domain need not
                  x += displacement_at(grid.clamped(x),
                                       group,
                                       active,
                                       displacement);
                  for (unsigned int d = 0; d < dim; ++d)
                    {
                      lowest[d] =
                        corner == 0 ? x[d] : std::min(lowest[d], x[d]);
                      highest[d] =
                        corner == 0 ? x[d] : std::max(highest[d], x[d]);
                    }
                }
              dealii::Tensor<1, dim> moved;
              double                 ratio =
                volume_ratio<dim>(trial, left_cauchy_green_less_unit, p);
              for (unsigned int d = 0; d < dim; ++d)
                {
                  moved[d] = 0.5 * l[d] / used[d] * (highest[d] - lowest[d]);
                  ratio *= initial[group.body][d] / moved[d];
                }
              trial.set(half_length, p, std::pow(ratio, 1. / dim) * moved);
            }
      }

      MiddleBox<dim>
      middle(const PointArrays<dim> &states,
             const std::size_t       p,
             const unsigned int,
             const dealii::Tensor<2, dim> &) const override
      {
        return {states.template get<dim>(half_length, p), {}};
      }

    private:
      /** Where the shape functions see a point: sum S x_A. */
      static dealii::Point<dim>
      place(const Stencils<dim>   &stencils,
            const Group<dim>      &group,
            const unsigned int     q,
            const ActiveGrid<dim> &active)
      {
        dealii::Point<dim> x;
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          x += stencils.value(group, a)[q] *
               dealii::Tensor<1, dim>(active.position(active.nodes(group)[a]));
        return x;
      }

      /** With the hats of the group's nodes. */
      dealii::Tensor<1, dim>
      displacement_at(const dealii::Point<dim>  &x,
                      const Group<dim>          &group,
                      const ActiveGrid<dim>     &active,
                      const std::vector<double> &displacement) const
      {
        dealii::Tensor<1, dim> result;
        double                 sum = 0.;
        for (unsigned int a = 0; a < group.n_nodes; ++a)
          {
            const unsigned int node   = active.nodes(group)[a];
            double             weight = 1.;
            for (unsigned int d = 0; d < dim; ++d)
              weight *=
                std::max(0.,
                         1. - std::abs(x[d] - active.position(node)[d]) /
                                grid.cell_size()[d]);
            sum += weight;
            for (unsigned int c = 0; c < dim; ++c)
              result[c] += weight * displacement[unknown<dim>(node, c)];
          }
        // one but for corners outside the overlapped cells, which clipping at
        // the grid's edge makes possible
        return result / sum;
      }

      const std::vector<dealii::Tensor<1, dim>> initial;
      const BackgroundGrid<dim>                &grid;
      const unsigned int half_length, left_cauchy_green_less_unit;
    };
  } // namespace

  template <int dim>
  std::string
  DomainUpdate<dim>::problem(const Stencils<dim>       &stencils,
                             const FieldLayout         &layout,
                             const BackgroundGrid<dim> &grid,
                             const PointArrays<dim>    &trial)
  {
    const unsigned int half_length = layout["half_length"];
    for (std::size_t p = 0; p < trial.n_points(); ++p)
      for (unsigned int d = 0; d < dim; ++d)
        {
          const double l = trial.component(half_length + d)[p],
                       h = grid.size_at(trial.point(p))[d];
          if (!(l > 1e-6 * h)) // NaN too
            return "the half-length of particle " +
                   std::to_string(stencils.particles[p]->get_id()) + " at (" +
                   dealii::Patterns::Tools::to_string(
                     stencils.particles[p]->get_location()) +
                   ") m along " + "xyz"[d] + " would become " + shortest(l) +
                   " m; it must stay above 1e-6 of the cell size " +
                   shortest(h) + " m";
        }
    return "";
  }

  template <int dim>
  std::uint64_t
  DomainUpdate<dim>::n_cut(const FieldLayout         &layout,
                           const BackgroundGrid<dim> &grid,
                           const PointArrays<dim>    &trial)
  {
    const unsigned int half_length = layout["half_length"];
    std::uint64_t      result      = 0;
    for (std::size_t p = 0; p < trial.n_points(); ++p)
      for (unsigned int d = 0; d < dim; ++d)
        if (trial.component(half_length + d)[p] >
            grid.size_at(trial.point(p))[d] * (1. + 1e-12))
          {
            ++result;
            break;
          }
    return dealii::Utilities::MPI::sum(result, grid.communicator());
  }

  std::string
  domain_update_names()
  {
    return "none|detF|diagF|stretch|corners";
  }

  template <int dim>
  std::unique_ptr<DomainUpdate<dim>>
  make_domain_update(const std::string            &name,
                     const std::vector<Body<dim>> &bodies,
                     const BackgroundGrid<dim>    &grid,
                     FieldLayout                  &layout)
  {
    std::vector<dealii::Tensor<1, dim>> initial;
    for (const Body<dim> &body : bodies)
      initial.push_back(initial_half_length(body, grid));
    if (name == "detF")
      return std::make_unique<VolumeUpdate<dim>>(initial, layout);
    if (name == "diagF" || name == "stretch")
      return std::make_unique<GradientUpdate<dim>>(name == "stretch",
                                                   initial,
                                                   layout);
    if (name == "corners")
      return std::make_unique<CornerUpdate<dim>>(initial, grid, layout);
    AssertThrow(name == "none",
                ExcParameter("Method",
                             "Domain update",
                             name,
                             "it must be one of " + domain_update_names() +
                               "."));
    return nullptr;
  }

  template <int dim>
  EffectCard
  domain_update_card(const DomainUpdate<dim> *update)
  {
    EffectCard card;
    card.name       = domain_update_effect;
    card.setting    = "Method/Domain update, with GIMP";
    card.enters     = "after Newton: sizes of the particles' domains";
    card.is_present = update != nullptr;
    return card;
  }

#define INSTANTIATE(dim)                                                  \
  template class DomainUpdate<dim>;                                       \
  template EffectCard domain_update_card<dim>(const DomainUpdate<dim> *); \
  template std::unique_ptr<DomainUpdate<dim>> make_domain_update<dim>(    \
    const std::string &,                                                  \
    const std::vector<Body<dim>> &,                                       \
    const BackgroundGrid<dim> &,                                          \
    FieldLayout &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
