// The stress with mean dilatation of a cell: it works exactly what the points
// store and dissipate, keeps angular momentum, turns with the body, is the
// derivative of the energy at the start of a step, and has the derivative that
// it says; for every material, elastic and flowing, on random cells.

#include <emmy/material/mean_dilatation.h>

#include "laws.h"

using namespace emmy;
using dealii::Tensor;
using test::all_laws_and_soils;
using test::identity;
using test::random_tensor;
using test::state_at;

namespace
{
  template <int dim>
  using Kind = typename MeanDilatationStress<dim>::Kind;

  constexpr unsigned int n_points = 4;

  template <int dim>
  using Gradients = std::array<Tensor<2, dim>, n_points>;

  /** Points of a cell, as they are at t. */
  template <int dim>
  struct Cell
  {
    std::vector<StressBatch<dim>> states;
    std::array<double, n_points>  volumes, volume_ratios;
  };

  /** What they are after a step. */
  template <int dim>
  struct Answer
  {
    std::vector<StressBatch<dim>>                batches;
    std::array<CellPoint<dim>, n_points>         points;
    std::array<CellLink<dim>, n_points>          links;
    std::array<dealii::Tensor<2, dim>, n_points> P;
    double volume = 0., stress = 0., own_by_mean = 0.; // V_c, P_c, x
    double energy = 0., work = 0., size = 0.;          // J
    bool   flows = false;
  };

  template <int dim>
  Cell<dim>
  random_cell(const Material<dim> &material, const double size)
  {
    std::uniform_real_distribution<double> uniform(0.7, 1.3);
    Cell<dim>                              cell;
    for (unsigned int q = 0; q < n_points; ++q)
      {
        cell.states.push_back(
          state_at<dim>(material,
                        random_tensor<dim>(size),
                        0.3 * size * (uniform(test::generator) - 1.)));
        cell.volumes[q]       = uniform(test::generator);
        cell.volume_ratios[q] = uniform(test::generator);
      }
    return cell;
  }

  template <int dim>
  Answer<dim>
  moved(const Material<dim>  &material,
        const Kind<dim>       kind,
        const Cell<dim>      &cell,
        const Gradients<dim> &H)
  {
    const MeanDilatationStress<dim> rule(kind);
    Answer<dim>                     result;
    result.batches = cell.states;
    double change  = 0.;
    for (unsigned int q = 0; q < n_points; ++q)
      {
        auto &point        = result.points[q];
        point.volume_ratio = cell.volume_ratios[q];
        point.own_change   = volume_change<dim>(H[q]);
        const double V     = cell.volumes[q] * cell.volume_ratios[q];
        result.volume += V;
        change += V * point.own_change;
        result.batches[q].displacement_gradient[0] = H[q];
        result.batches[q].with_tangent             = true;
      }
    for (unsigned int q = 0; q < n_points; ++q)
      {
        auto &point       = result.points[q];
        auto &batch       = result.batches[q];
        point.mean_change = change / result.volume;
        rule.own_stress(material, batch, &point);
        const double V0 = cell.volumes[q];
        result.stress += V0 * point.mean_stress / result.volume;
        result.own_by_mean += V0 * point.mean_stress_by_mean / result.volume;
        const auto &end  = batch.material;
        double      gain = end.stored_energy[0] - batch.stored_energy_old[0];
        result.size += V0 * (std::abs(end.stored_energy[0]) +
                             std::abs(batch.stored_energy_old[0]));
        if (batch.is_inelastic)
          {
            gain += end.hardening_energy[0] - batch.hardening_energy_old[0] +
                    end.dissipation[0];
            result.size += V0 * end.dissipation[0];
            result.flows = result.flows || end.dissipation[0] > 0.;
          }
        result.energy += V0 * gain;
      }
    for (unsigned int q = 0; q < n_points; ++q)
      {
        result.links[q] = rule.whole_stress(result.points[q],
                                            result.stress,
                                            0,
                                            result.batches[q]);
        result.P[q]     = result.batches[q].nominal_stress[0];
        result.work += cell.volumes[q] * scalar_product(result.P[q], H[q]);
      }
    return result;
  }

  template <int dim>
  Gradients<dim>
  random_step(const double size)
  {
    Gradients<dim> H;
    for (auto &gradient : H)
      gradient = random_tensor<dim>(size);
    return H;
  }

  template <int dim>
  double
  norm(const Answer<dim> &answer)
  {
    double sum = 0.;
    for (const auto &P : answer.P)
      sum += P.norm_square();
    return std::sqrt(sum);
  }

  /** dP of all points for dH, as the rule says. */
  template <int dim>
  Gradients<dim>
  derivative(const Cell<dim>      &cell,
             const Answer<dim>    &at,
             const Gradients<dim> &dH)
  {
    double d_mean = 0., d_stress = 0.;
    for (unsigned int q = 0; q < n_points; ++q)
      {
        d_mean += cell.volumes[q] * cell.volume_ratios[q] / at.volume *
                  scalar_product(at.links[q].change_by_H, dH[q]);
        d_stress += cell.volumes[q] / at.volume *
                    scalar_product(at.links[q].mean_stress_by_H, dH[q]);
      }
    d_stress += at.own_by_mean * d_mean;
    Gradients<dim> dP;
    for (unsigned int q = 0; q < n_points; ++q)
      {
        dP[q] = d_mean * at.links[q].stress_by_mean +
                d_stress * at.links[q].stress_by_mean_stress;
        for (unsigned int r = 0; r < dim * dim; ++r)
          for (unsigned int c = 0; c < dim * dim; ++c)
            dP[q][r / dim][r % dim] +=
              at.batches[q].tangent[0][r][c] * dH[q][c / dim][c % dim];
      }
    return dP;
  }

  template <int dim>
  Gradients<dim>
  sum(const Gradients<dim> &a, const double factor, const Gradients<dim> &b)
  {
    Gradients<dim> result;
    for (unsigned int q = 0; q < n_points; ++q)
      result[q] = a[q] + factor * b[q];
    return result;
  }

  template <int dim>
  void
  check_tangent(const Material<dim>  &material,
                const Kind<dim>       kind,
                const Cell<dim>      &cell,
                const Gradients<dim> &H,
                const std::string    &what)
  {
    constexpr double delta = 1e-6;
    const auto       at    = moved<dim>(material, kind, cell, H);
    const auto       dH    = random_step<dim>(1.);
    const auto       plus = moved<dim>(material, kind, cell, sum(H, delta, dH)),
               minus = moved<dim>(material, kind, cell, sum(H, -delta, dH));
    const auto dP    = derivative<dim>(cell, at, dH);
    double     error = 0., size = 0.;
    for (unsigned int q = 0; q < n_points; ++q)
      {
        error +=
          ((plus.P[q] - minus.P[q]) / (2. * delta) - dP[q]).norm_square();
        size += dP[q].norm_square();
      }
    test::check_close(std::sqrt(error / size), 0., 1e-7, what + ": tangent");
  }

  template <int dim>
  void
  check_random(const Material<dim> &material,
               const double         size,
               const std::string   &name)
  {
    const auto   kind    = Kind<dim>::conserving;
    unsigned int n_flows = 0;
    for (unsigned int sample = 0; sample < 20; ++sample)
      {
        const auto cell = random_cell<dim>(material, 0.2);
        const auto H    = random_step<dim>(size);
        const auto p    = moved<dim>(material, kind, cell, H);
        n_flows += p.flows;
        test::check_close(p.work,
                          p.energy,
                          1e-13 * (p.size + std::abs(p.work)),
                          name + ": work");
        for (unsigned int q = 0; q < n_points; ++q)
          {
            // P = Fm S with a symmetric S
            const auto S = invert(identity<dim>() + 0.5 * H[q]) * p.P[q];
            test::check_close((S - transpose(S)).norm(),
                              0.,
                              1e-13 * norm(p),
                              name + ": symmetry");
          }
        // turned at the end of the step: S is the same
        Gradients<dim> turned = H;
        const double   angle  = 0.7;
        Tensor<2, dim> R      = identity<dim>();
        R[0][0] = R[1][1] = std::cos(angle);
        R[1][0]           = std::sin(angle);
        R[0][1]           = -R[1][0];
        for (auto &gradient : turned)
          gradient = R * (identity<dim>() + gradient) - identity<dim>();
        const auto t = moved<dim>(material, kind, cell, turned);
        for (unsigned int q = 0; q < n_points; ++q)
          test::check_close((invert(identity<dim>() + 0.5 * turned[q]) *
                               t.P[q] -
                             invert(identity<dim>() + 0.5 * H[q]) * p.P[q])
                              .norm(),
                            0.,
                            1e-11 * norm(p),
                            name + ": objectivity");
        for (const auto each : {Kind<dim>::conserving, Kind<dim>::at_rest})
          check_tangent<dim>(material,
                             each,
                             cell,
                             H,
                             name +
                               (each == Kind<dim>::at_rest ? ", at rest" : ""));
      }
    if (name.find("elastic") == std::string::npos &&
        !material.history().empty())
      test::check(n_flows > 0, name + ": some points flow");
  }

  /** The stress of a step of nothing is the derivative of the energy. */
  template <int dim>
  void
  check_start(const Material<dim> &material, const std::string &name)
  {
    const auto       kind  = Kind<dim>::at_rest;
    constexpr double delta = 1e-5;
    const auto       cell  = random_cell<dim>(material, 0.02);
    const auto       start =
      moved<dim>(material, Kind<dim>::conserving, cell, Gradients<dim>());
    const auto dH    = random_step<dim>(1.);
    const auto plus  = moved<dim>(material, kind, cell, sum({}, delta, dH)),
               minus = moved<dim>(material, kind, cell, sum({}, -delta, dH));
    double expected  = 0.;
    for (unsigned int q = 0; q < n_points; ++q)
      expected += cell.volumes[q] * scalar_product(start.P[q], dH[q]);
    test::check_close((plus.energy - minus.energy) / (2. * delta),
                      expected,
                      1e-8 * norm(start),
                      name + ": stress at the start");
    test::check(!plus.flows && !minus.flows, name + ": nothing flows");
  }

  /** A cell of points that move alike is a point without treatment. */
  template <int dim>
  void
  check_alike(const Material<dim> &material, const std::string &name)
  {
    Cell<dim> cell = random_cell<dim>(material, 0.2);
    for (unsigned int q = 1; q < n_points; ++q)
      cell.states[q] = cell.states[0];
    Gradients<dim> H;
    H.fill(random_tensor<dim>(0.1));
    const auto p      = moved<dim>(material, Kind<dim>::conserving, cell, H);
    const auto single = test::moved<dim>(material,
                                         stress_rule<dim>("conserving"),
                                         cell.states[0],
                                         H[0]);
    test::check_close((p.batches[0].material.kirchhoff_stress[0] -
                       single.material.kirchhoff_stress[0])
                        .norm(),
                      0.,
                      1e-12 * single.material.kirchhoff_stress[0].norm(),
                      name + ": stress of points that move alike");
  }

  /**
   * What a body has flowed before is no matter to the stress: squeezed to a
   * fifth, with the same elastic strain, it has the same. Newton stalled in
   * the foot of the Taylor bar when the energy's correction was along
   * b_t A b_t with the whole b_t.
   */
  template <int dim>
  void
  check_flow_of_before(const Material<dim> &material, const std::string &name)
  {
    Cell<dim>  cell = random_cell<dim>(material, 0.1);
    const auto H    = random_step<dim>(0.1);
    if (!cell.states[0].is_inelastic)
      return;
    const auto fresh = moved<dim>(material, Kind<dim>::conserving, cell, H);
    for (auto &state : cell.states)
      {
        auto &b = state.left_cauchy_green_less_unit_old[0];
        b[0] = b[2] = 4.;
        b[1]        = -0.96;
      }
    const auto squeezed = moved<dim>(material, Kind<dim>::conserving, cell, H);
    for (unsigned int q = 0; q < n_points; ++q)
      test::check_close((fresh.P[q] - squeezed.P[q]).norm(),
                        0.,
                        1e-13 * norm(fresh),
                        name + ": the flow of before");
  }

  template <int dim>
  void
  check_all()
  {
    const std::string space = dim == 2 ? " in the plane" : " in space";
    for (const auto &law : all_laws_and_soils<dim>())
      {
        check_random<dim>(*law.material, 0.1, law.name + space);
        check_alike<dim>(*law.material, law.name + space);
        check_flow_of_before<dim>(*law.material, law.name + space);
        check_start<dim>(*law.material, law.name + space);
      }
  }
} // namespace

int
main()
{
  check_all<2>();
  check_all<3>();
  return test::report();
}
