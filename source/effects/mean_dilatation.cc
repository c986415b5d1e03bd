#include <emmy/effects/cell_products.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/effects/point_sums.h>
#include <emmy/effects/stress_tangent.h>

#include <algorithm>
#include <optional>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    Field
    volume_ratio_field()
    {
      return {own_volume_field,
              Field::Kind::scalar,
              "1",
              "det F - 1 of the particle's own motion, not that of the cell"};
    }

    Field
    mean_stress_field()
    {
      return {cell_mean_stress_field,
              Field::Kind::scalar,
              "Pa",
              "mean Cauchy stress of the particles of the cell that the "
              "particle was in at the start of the step"};
    }

    unsigned int
    first_of_treatment(FieldLayout &layout)
    {
      layout.set_effect(mean_dilatation_effect);
      return layout.add(volume_ratio_field());
    }
  } // namespace

  template <int dim>
  MeanDilatation<dim>::MeanDilatation(
    std::vector<const Material<dim> *> material_of_body,
    FieldLayout                       &layout,
    const Kind                         kind,
    std::vector<std::string>           names,
    std::vector<bool>                  is_averaged)
    : kind(kind)
    , rule(kind)
    , states(material_of_body, std::move(names), layout)
    , volume_ratio_less_one(first_of_treatment(layout))
    , mean_stress(layout.add(mean_stress_field()))
    , material_of_body(std::move(material_of_body))
    , is_averaged(std::move(is_averaged))
    , work(std::make_unique<Work>())
  {}

  template <int dim>
  EffectCard
  MeanDilatation<dim>::card(const bool is_present)
  {
    EffectCard card;
    card.name       = mean_dilatation_effect;
    card.setting    = "Method/Locking treatment = cell";
    card.enters     = "Newton: the volume of a cell's particles changes alike";
    card.fields     = {volume_ratio_field(), mean_stress_field()};
    card.couples    = "all nodes that the particles of a cell reach";
    card.is_present = is_present;
    return card;
  }

  template <int dim>
  bool
  MeanDilatation<dim>::has_kinks() const
  {
    return std::any_of(material_of_body.begin(),
                       material_of_body.end(),
                       [](const auto *material) {
                         return !material->history().empty();
                       });
  }

  template <int dim>
  void
  MeanDilatation<dim>::couple(const Stencils<dim> &stencils,
                              const BackgroundGrid<dim> &,
                              const BoundaryConditions<dim> &,
                              Couplings<dim> &couplings)
  {
    work->cells.find(stencils, material_of_body, is_averaged);
    work->cells.add_to(couplings);
  }

  template <int dim>
  std::string
  MeanDilatation<dim>::add(const StepData<dim> &step,
                           const Iterate<dim>  &iterate,
                           Vector              &force,
                           Matrix              *jacobian) const
  {
    const std::size_t n = step.stencils.particles.size();
    Assert(work->cells.group_of_point.size() == n,
           dealii::ExcMessage("couple() was not for these points"));
    work->points.resize(n);
    work->gradients.resize(n);
    work->box_scales.resize(n);
    work->links.resize(jacobian ? n : 0);
    work->nodal_force.assign(dim * step.start.active->n_local_nodes(), 0.);
    work->energy             = 0.;
    work->batch.with_tangent = jacobian != nullptr;

    std::string problem = find_ratios(step, iterate);
    if (problem.empty())
      problem = find_own_stresses(step, iterate);
    if (problem.empty())
      {
        add_stresses(step, iterate, jacobian);
        if (jacobian)
          add_cells(step, iterate, *jacobian);
      }
    step.start.active->add(work->nodal_force,
                           force); // collective: also after a problem
    return problem;
  }

  template <int dim>
  void
  MeanDilatation<dim>::begin_batch(const PointBatch<dim> &points) const
  {
    auto &batch    = work->batch;
    batch.n_points = points.n_points;
    for (unsigned int q = 0; q < batch.n_points; ++q)
      batch.displacement_gradient[q] = work->gradients[points.first_point + q];
  }

  template <int dim>
  std::string
  MeanDilatation<dim>::find_ratios(const StepData<dim> &step,
                                   const Iterate<dim>  &iterate) const
  {
    for (auto &pool : work->cells.pools)
      pool.volume = pool.change = pool.stress = pool.stress_end =
        pool.own_by_mean                      = 0.;
    auto         &batch   = work->batch;
    const double *volumes = states.reference_volumes(step.points);
    const double *ratios  = step.points.component(volume_ratio_less_one);
    for (PointBatch<dim> points(step.stencils); points.next();)
      {
        const std::size_t first = points.first_point;
        displacement_gradients(points,
                               *step.start.active,
                               iterate.local_displacement,
                               batch);
        for (unsigned int q = 0; q < batch.n_points; ++q)
          work->gradients[first + q] = batch.displacement_gradient[q];
        if (step.stencils.at_middle)
          {
            const unsigned int inverted = work->middle.to_start(batch);
            if (inverted < batch.n_points)
              return inverted_particle(step.stencils, first + inverted);
          }
        for (unsigned int q = 0; q < batch.n_points; ++q)
          {
            const std::size_t p    = first + q;
            CellPoint<dim>   &here = work->points[p];
            auto             &pool = work->cells.pool_of(p);
            here.volume_ratio      = 1. + ratios[p];
            here.own_change =
              volume_change<dim>(batch.displacement_gradient[q]);
            if (!(here.own_change > -1.)) // NaN too
              return inverted_particle(step.stencils, p);
            const double V = volumes[p] * here.volume_ratio;
            pool.volume += V;
            pool.change += V * here.own_change;
          }
      }
    for (auto &pool : work->cells.pools)
      pool.change /= pool.volume;
    for (std::size_t p = 0; p < work->points.size(); ++p)
      work->points[p].mean_change = work->cells.pool_of(p).change;
    return {};
  }

  template <int dim>
  std::string
  MeanDilatation<dim>::find_own_stresses(const StepData<dim> &step,
                                         const Iterate<dim>  &iterate) const
  {
    auto             &batch   = work->batch;
    const double     *volumes = states.reference_volumes(step.points);
    const std::string problem = states.for_each_batch(
      step.stencils,
      step.phases,
      [&](const PointBatch<dim> &points) -> std::string {
        const std::size_t first = points.first_point;
        begin_batch(points);
        if (step.stencils.at_middle)
          work->middle.to_start(batch);
        states.read(step.points, points.body, first, batch);
        rule.own_stress(states.material(points.body),
                        batch,
                        &work->points[first]);
        states.write(batch, step.points, points.body, first, iterate.trial);
        for (unsigned int q = 0; q < batch.n_points; ++q)
          {
            const CellPoint<dim> &here = work->points[first + q];
            auto                 &pool = work->cells.pool_of(first + q);
            pool.stress += volumes[first + q] * here.mean_stress;
            pool.stress_end += volumes[first + q] * here.mean_stress_end;
            pool.own_by_mean += volumes[first + q] * here.mean_stress_by_mean;
          }
        return {};
      });
    for (auto &pool : work->cells.pools)
      {
        pool.stress /= pool.volume;
        pool.own_by_mean /= pool.volume;
        pool.stress_end /= pool.volume * (1. + pool.change);
      }
    double *ratios     = iterate.trial.component(volume_ratio_less_one);
    double *cell_means = iterate.trial.component(mean_stress);
    for (std::size_t p = 0; p < work->points.size(); ++p)
      {
        const CellPoint<dim> &here = work->points[p];
        ratios[p] =
          here.volume_ratio - 1. + here.volume_ratio * here.own_change;
        cell_means[p] = work->cells.pool_of(p).stress_end;
        work->box_scales[p] =
          std::pow((1. + here.mean_change) / (1. + here.own_change), 0.5 / dim);
      }
    return problem;
  }

  template <int dim>
  void
  MeanDilatation<dim>::add_stresses(const StepData<dim> &step,
                                    const Iterate<dim>  &iterate,
                                    Matrix              *jacobian) const
  {
    auto         &batch   = work->batch;
    const double *volumes = states.reference_volumes(step.points);
    std::optional<StressTangent<dim>> tangent;
    if (jacobian)
      tangent.emplace(step, iterate, *jacobian);
    for (PointBatch<dim> points(step.stencils); points.next();)
      {
        const std::size_t first = points.first_point;
        begin_batch(points);
        find_whole_stresses(step, first);
        for (unsigned int q = 0; q < batch.n_points; ++q)
          work->energy +=
            volumes[first + q] * scalar_product(batch.nominal_stress[q],
                                                batch.displacement_gradient[q]);
        add_forces(
          points, *step.start.active, volumes, batch, work->nodal_force);
        if (jacobian)
          tangent->add(
            points,
            {batch, work->middle, volumes + first, &work->box_scales[first]});
      }
    if (jacobian)
      tangent->finish();
  }

  template <int dim>
  void
  MeanDilatation<dim>::find_whole_stresses(const StepData<dim> &step,
                                           const std::size_t    point) const
  {
    auto &batch = work->batch;
    if (step.stencils.at_middle)
      work->middle.to_start(batch);
    for (unsigned int q = 0; q < batch.n_points; ++q)
      {
        const std::size_t p    = point + q;
        const auto       &pool = work->cells.pool_of(p);
        const auto        link =
          rule.whole_stress(work->points[p], pool.stress, q, batch);
        if (!batch.with_tangent)
          continue;
        work->links[p] = link;
        if (!step.stencils.at_middle)
          continue;
        // S-hat = P Z^T, and dH = Z dL Z
        const Tensor<2, dim> Zt    = transpose(work->middle.from_start(q));
        CellLink<dim>       &here  = work->links[p];
        here.stress_by_mean_stress = link.stress_by_mean_stress * Zt;
        here.stress_by_mean        = link.stress_by_mean * Zt;
        here.change_by_H           = Zt * link.change_by_H * Zt;
        here.mean_stress_by_H      = Zt * link.mean_stress_by_H * Zt;
      }
    if (step.stencils.at_middle)
      work->middle.to_middle(batch);
  }

  template <int dim>
  void
  MeanDilatation<dim>::add_cells(const StepData<dim> &step,
                                 const Iterate<dim>  &iterate,
                                 Matrix              &jacobian) const
  {
    const double     *volumes = states.reference_volumes(step.points);
    CellProducts<dim> products(step, iterate, work->cells, work->links);
    for (const auto &pool : work->cells.pools)
      {
        products.begin(pool);
        for (const std::size_t p : pool.points)
          {
            const double V0 = volumes[p];
            products.add_point(p,
                               {V0,
                                V0 * work->points[p].volume_ratio / pool.volume,
                                V0 / pool.volume});
          }
        products.add_to(jacobian);
      }
    products.finish();
  }

  template <int dim>
  std::vector<EnergyEntry>
  MeanDilatation<dim>::energies(const StepData<dim> &step,
                                const Vector &,
                                const PointArrays<dim> &accepted) const
  {
    std::vector<EnergyEntry> entries = states.energies(step.points, accepted);
    if (kind == Kind::conserving)
      return entries;
    double known = 0.;
    for (const EnergyEntry &entry : entries)
      known += entry.change;
    entries.push_back({"stress_rule_loss",
                       EnergyEntry::Kind::dissipated,
                       work->energy - known});
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  MeanDilatation<dim>::energy_entries() const
  {
    std::vector<EnergyEntry> entries = states.energy_entries();
    if (kind != Kind::conserving)
      entries.push_back(
        {"stress_rule_loss", EnergyEntry::Kind::dissipated, 0.});
    return entries;
  }

  template class MeanDilatation<2>;
  template class MeanDilatation<3>;
} // namespace emmy
