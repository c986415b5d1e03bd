#include <emmy/effects/cell_products.h>

namespace emmy
{
  using dealii::Tensor;

  template <int dim>
  CellProducts<dim>::CellProducts(const StepData<dim>              &step,
                                  const Iterate<dim>               &iterate,
                                  const CellPools<dim>             &cells,
                                  const std::vector<CellLink<dim>> &links)
    : step(step)
    , iterate(iterate)
    , cells(cells)
    , links(links)
    , index_of(step.start.active->n_local_nodes())
    , share(step.moving ? dim * index_of.size() : 0)
  {}

  template <int dim>
  void
  CellProducts<dim>::begin(const Pool &pool)
  {
    this->pool                 = &pool;
    const unsigned int  n_here = pool.node_ids.size();
    const unsigned int *nodes =
      step.start.active->coupled_nodes(pool.first_coupled);
    for (unsigned int a = 0; a < n_here; ++a)
      index_of[nodes[a]] = a;
    for (auto *vector : {&s, &n, &t, &pi})
      vector->assign(dim * n_here, 0.);
    t_shift = pi_shift = 0.;
  }

  template <int dim>
  void
  CellProducts<dim>::add_point(const std::size_t p, const Weights &weights)
  {
    const Group         &group = step.stencils.groups[cells.group_of_point[p]];
    const unsigned int   q     = p - group.first_point;
    const unsigned int  *nodes = step.start.active->nodes(group);
    const CellLink<dim> &link  = links[p];
    const Tensor<2, dim> by_mean = weights.force * link.stress_by_mean,
                         by_mean_stress =
                           weights.force * link.stress_by_mean_stress,
                         ratio    = weights.ratio * link.change_by_H,
                         pressure = weights.stress * link.mean_stress_by_H;
    for (unsigned int a = 0; a < group.n_nodes; ++a)
      {
        Tensor<1, dim> g;
        for (unsigned int d = 0; d < dim; ++d)
          g[d] = step.stencils.gradient(group, a, d)[q];
        const unsigned int first = dim * index_of[nodes[a]];
        const auto s_a = by_mean * g, n_a = by_mean_stress * g, t_a = ratio * g,
                   pi_a = pressure * g;
        for (unsigned int c = 0; c < dim; ++c)
          {
            s[first + c] += s_a[c];
            n[first + c] += n_a[c];
            t[first + c] += t_a[c];
            pi[first + c] += pi_a[c];
          }
      }
    if (step.moving)
      add_place(group, p, ratio, pressure);
  }

  template <int dim>
  void
  CellProducts<dim>::add_place(const Group          &group,
                               const std::size_t     p,
                               const Tensor<2, dim> &ratio,
                               const Tensor<2, dim> &pressure)
  {
    // L changes with the place too, and the place with the motion
    const unsigned int  q     = p - group.first_point;
    const unsigned int *nodes = step.start.active->nodes(group);
    step.moving->differentiate(step, group, q, derivatives);
    const auto &response = step.moving->response_of(p);
    std::array<std::array<double, dim + 1>, dim> t_by_motion{}, pi_by_motion{};
    for (unsigned int k = 0; k < step.moving->n_place_unknowns(); ++k)
      {
        Tensor<2, dim> L_by_q;
        for (unsigned int d = 0; d < dim; ++d)
          {
            const double *slope = derivatives.gradient(k, d);
            for (unsigned int a = 0; a < group.n_nodes; ++a)
              for (unsigned int c = 0; c < dim; ++c)
                L_by_q[c][d] +=
                  iterate.local_displacement[unknown<dim>(nodes[a], c)] *
                  slope[a];
          }
        const double t_by_q  = scalar_product(ratio, L_by_q),
                     pi_by_q = scalar_product(pressure, L_by_q);
        t_shift += t_by_q * response.shift[k];
        pi_shift += pi_by_q * response.shift[k];
        for (unsigned int j = 0; j < dim; ++j)
          for (unsigned int l = 0; l <= dim; ++l)
            {
              t_by_motion[j][l] += t_by_q * response.by_motion[k][j][l];
              pi_by_motion[j][l] += pi_by_q * response.by_motion[k][j][l];
            }
      }
    for (unsigned int a = 0; a < group.n_nodes; ++a)
      {
        const unsigned int first = dim * index_of[nodes[a]];
        for (unsigned int j = 0; j < dim; ++j)
          for (unsigned int l = 0; l <= dim; ++l)
            {
              const double weight =
                l == 0 ? step.stencils.value(group, a)[q]
                       : step.stencils.gradient(group, a, l - 1)[q];
              t[first + j] += t_by_motion[j][l] * weight;
              pi[first + j] += pi_by_motion[j][l] * weight;
            }
      }
  }

  template <int dim>
  void
  CellProducts<dim>::add_to(Matrix &jacobian)
  {
    const ActiveGrid<dim> &active = *step.start.active;
    const unsigned int    *nodes  = active.coupled_nodes(pool->first_coupled);
    const unsigned int     size   = t.size();
    for (unsigned int i = 0; i < size; ++i)
      pi[i] += pool->own_by_mean * t[i];
    block.reinit(size, size, true);
    for (unsigned int i = 0; i < size; ++i)
      for (unsigned int k = 0; k < size; ++k)
        block(i, k) = s[i] * t[k] + n[i] * pi[k];
    active.graph().add(nodes, block, jacobian);
    if (!step.moving)
      return;
    const double stress_shift = pi_shift + pool->own_by_mean * t_shift;
    for (unsigned int a = 0; a < size / dim; ++a)
      for (unsigned int c = 0; c < dim; ++c)
        share[unknown<dim>(nodes[a], c)] +=
          s[dim * a + c] * t_shift + n[dim * a + c] * stress_shift;
  }

  template <int dim>
  void
  CellProducts<dim>::finish()
  {
    if (step.moving)
      step.moving->add_to_share(share);
  }

  template class CellProducts<2>;
  template class CellProducts<3>;
} // namespace emmy
