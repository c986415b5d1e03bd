#include <emmy/material/neo_hooke.h>
#include <emmy/math/spectral.h>

namespace emmy
{
  template <int dim>
  NeoHooke<dim>::NeoHooke(const ElasticConstants &constants)
    : reference_density(constants.density)
    , lambda(constants.bulk_modulus - 2. / 3. * constants.shear_modulus)
    , shear_modulus(constants.shear_modulus)
  {}

  template <int dim>
  void
  NeoHooke<dim>::evaluate(MaterialBatch<dim> &batch) const
  {
    const double G = shear_modulus;
    const auto   I = mandel::unit<dim>();
    for (unsigned int p = 0; p < batch.n_points; ++p)
      {
        // b - I and its invariants: small strains keep their digits
        const auto &b_less_I    = batch.left_cauchy_green_less_unit[p];
        const auto [i1, i2, i3] = mandel::invariants<dim>(b_less_I);
        const double x          = i1 + i2 + i3; // J^2 - 1
        const double ln_J       = 0.5 * std::log1p(x);

        batch.kirchhoff_stress[p] = G * b_less_I + (lambda * ln_J) * I;
        // tr b - 3 - 2 ln J = x - ln(1 + x) - i2 - i3
        batch.stored_energy[p] =
          0.5 * G * (less_log1p(x) - i2 - i3) + 0.5 * lambda * ln_J * ln_J;
        if (batch.with_tangent)
          {
            batch.spatial_tangent[p] = lambda * outer_product(I, I);
            for (unsigned int i = 0; i < n_mandel<dim>; ++i)
              batch.spatial_tangent[p][i][i] += 2. * (G - lambda * ln_J);
          }
        if (batch.with_energy_change)
          batch.stored_energy_change[p] = energy_change(batch, p);
      }
  }

  template <int dim>
  double
  NeoHooke<dim>::energy_change(const MaterialBatch<dim> &batch,
                               const unsigned int        p) const
  {
    // With A = Delta F^T Delta F - I and j = det(I + H) - 1, exactly
    // tr b - tr b_t = b_t : A and ln J - ln J_t = ln(1 + j); and of these
    // tr A/2 - ln(1 + j) = H:H/2 - i2 - i3 + j - ln(1 + j), where i2 and i3
    // are the invariants of H
    const auto  &H     = batch.step.displacement_gradient[p];
    const auto  &b_old = batch.step.left_cauchy_green_less_unit_old[p];
    const double h = batch.step.out_of_plane ? batch.step.out_of_plane[p] : 0.;
    const auto   A =
      mandel::symmetric_part<dim>(2. * H + transpose(H) * H, (2. + h) * h);
    double i2, i3 = 0.;
    if constexpr (dim == 2)
      {
        i2 = determinant(H) + h * trace(H);
        i3 = h * determinant(H);
      }
    else
      {
        i2 = 0.;
        for (unsigned int i = 0; i < 3; ++i)
          {
            const unsigned int k = (i + 1) % 3;
            i2 += H[i][i] * H[k][k] - H[i][k] * H[k][i];
          }
        i3 = determinant(H);
      }
    const double j      = trace(H) + h + i2 + i3;
    const double change = std::log1p(j);
    const double ln_J_old =
      0.5 * std::log1p(mandel::determinant_less_one<dim>(b_old));
    return 0.5 * shear_modulus * (b_old * A) +
           shear_modulus *
             (0.5 * (scalar_product(H, H) + h * h) - i2 - i3 + less_log1p(j)) +
           0.5 * lambda * (2. * ln_J_old + change) * change;
  }

  template <int dim>
  bool
  NeoHooke<dim>::gives_energy_change() const
  {
    return true;
  }

  template <int dim>
  double
  NeoHooke<dim>::density() const
  {
    return reference_density;
  }

  template <int dim>
  double
  NeoHooke<dim>::p_wave_modulus() const
  {
    return lambda + 2. * shear_modulus;
  }

  template <int dim>
  double
  NeoHooke<dim>::shear_wave_modulus() const
  {
    return shear_modulus;
  }

  template <int dim>
  NeoHookeParameters<dim>::NeoHookeParameters(const std::string &section)
    : MaterialParameters<dim>(section)
  {
    constants.add_to(*this);
  }

  template <int dim>
  std::unique_ptr<Material<dim>>
  NeoHookeParameters<dim>::make() const
  {
    return std::make_unique<NeoHooke<dim>>(constants.completed(this->path()));
  }

  template class NeoHooke<2>;
  template class NeoHooke<3>;
  template class NeoHookeParameters<2>;
  template class NeoHookeParameters<3>;
} // namespace emmy
