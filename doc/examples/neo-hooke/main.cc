// emmy with one more value of <Model>, compressible neo-Hooke elasticity:
//   psi = G/2 (tr b - 3 - 2 ln J) + lambda/2 (ln J)^2.
#include <emmy/material/material.h>
#include <emmy/math/spectral.h>
#include <emmy/study/program.h>

using namespace emmy;

template <int dim>
struct NeoHooke : public Material<dim>
{
  double rho = 0., lambda = 0., G = 0.; // kg/m^3, Pa, Pa

  double
  density() const override
  {
    return rho;
  }
  double
  p_wave_modulus() const override
  {
    return lambda + 2. * G;
  }
  void
  evaluate(MaterialBatch<dim> &batch) const override
  {
    const auto I = mandel::unit<dim>(); // symmetric tensors are vectors
    for (unsigned int p = 0; p < batch.n_points; ++p)
      {
        // b - I and the invariants of it: small strains keep their digits
        const auto &b_less_I    = batch.left_cauchy_green_less_unit[p];
        const auto [i1, i2, i3] = mandel::invariants<dim>(b_less_I);
        const double x          = i1 + i2 + i3; // J^2 - 1
        const double ln_J       = 0.5 * std::log1p(x);
        // tr b - 3 - 2 ln J
        const double isochoric    = less_log1p(x) - i2 - i3;
        batch.kirchhoff_stress[p] = G * b_less_I + lambda * ln_J * I;
        batch.stored_energy[p] =
          0.5 * G * isochoric + 0.5 * lambda * ln_J * ln_J;
        batch.spatial_tangent[p] = lambda * outer_product(I, I);
        for (unsigned int i = 0; i < n_mandel<dim>; ++i)
          batch.spatial_tangent[p][i][i] += 2. * (G - lambda * ln_J);
      }
  }
};

template <int dim>
struct NeoHookeParameters : public MaterialParameters<dim>
{
  NeoHooke<dim> material; // as the parameter file describes it

  NeoHookeParameters(const std::string &section)
    : MaterialParameters<dim>(section)
  {
    this->add_parameter("Density", material.rho, "kg/m^3. Required.");
    this->add_parameter("Lame modulus", material.lambda, "lambda, Pa.");
    this->add_parameter("Shear modulus", material.G, "G, Pa. Required.");
  }
  std::unique_ptr<Material<dim>>
  make() const override
  {
    AssertThrow(material.rho > 0. && material.G > 0.,
                dealii::ExcMessage(
                  this->path() +
                  ": Density and Shear modulus must be positive."));
    return std::make_unique<NeoHooke<dim>>(material);
  }
};

template <int dim>
std::unique_ptr<MaterialParameters<dim>>
make(const std::string &section)
{
  return std::make_unique<NeoHookeParameters<dim>>(section);
}

int
main(int argc, char *argv[])
{
  material_library<2>().add({"my neo-Hooke", "neo-Hooke elasticity", make<2>});
  material_library<3>().add({"my neo-Hooke", "neo-Hooke elasticity", make<3>});
  return run_program(argc, argv);
}
