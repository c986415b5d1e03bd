// A material of our own. The headers are the interface of materials, helpers
// for small numbers, and the program.
#include <emmy/material/material.h>
#include <emmy/math/spectral.h>
#include <emmy/study/program.h>

#include <cmath>
#include <iostream>

using namespace emmy;

// The material itself. `Material` wants a density, the modulus of pressure
// waves, from which steps are chosen, and `evaluate`, which fills a batch of up
// to 32 points. Here the constants are public: the section below fills them.
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

  // Symmetric tensors are vectors in Mandel's notation: shear components are
  // multiplied by the square root of two, so that a product of vectors is the
  // double contraction of tensors. In plane strain there are four components:
  // 11, 22, 12 and 33.
  void
  evaluate(MaterialBatch<dim> &batch) const override
  {
    const auto I = mandel::unit<dim>();
    for (unsigned int p = 0; p < batch.n_points; ++p)
      {
        // The batch holds b - I, not b. With x = J^2 - 1 from the invariants
        // of b - I, small strains keep all their digits: tr b - 3 - 2 ln J is
        // written without a difference of large numbers.
        const auto &b_less_I    = batch.left_cauchy_green_less_unit[p];
        const auto [i1, i2, i3] = mandel::invariants<dim>(b_less_I);
        const double x          = i1 + i2 + i3;
        const double ln_J       = 0.5 * std::log1p(x);
        const double isochoric  = less_log1p(x) - i2 - i3;

        batch.kirchhoff_stress[p] = G * b_less_I + lambda * ln_J * I;
        batch.stored_energy[p] =
          0.5 * G * isochoric + 0.5 * lambda * ln_J * ln_J;

        // The tangent of the Lie derivative: lambda I x I + 2 (G - lambda
        // ln J) times the identity.
        batch.spatial_tangent[p] = lambda * outer_product(I, I);
        for (unsigned int i = 0; i < n_mandel<dim>; ++i)
          batch.spatial_tangent[p][i][i] += 2. * (G - lambda * ln_J);
      }
  }
};

// The section of the parameter file. `make` is called only for a material that
// a scene names; it refuses what cannot be.
template <int dim>
struct NeoHookeParameters : public MaterialParameters<dim>
{
  NeoHooke<dim> material;

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

// A point with b = F F^T.
template <int dim>
MaterialBatch<dim>
point(const NeoHooke<dim> &material, const dealii::Tensor<2, dim> &F)
{
  MaterialBatch<dim> batch;
  batch.n_points = 1;
  batch.left_cauchy_green_less_unit[0] =
    mandel::symmetric_part<dim>(F * transpose(F), 1.) - mandel::unit<dim>();
  material.evaluate(batch);
  return batch;
}

// Newton needs the derivative; without a test nobody knows whether it is right.
// The point is moved by F -> (I +- e d) F with a symmetric d. Then the energy
// must change by tau : d, and the stress by c : d + d tau + tau d. Centred
// differences with e and e/2 must differ from that by a factor of four.
template <int dim>
double
tangent_error(const double e)
{
  NeoHooke<dim> material;
  material.rho    = 1.;
  material.lambda = 57.7;
  material.G      = 38.5;
  dealii::Tensor<2, dim> F, d;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int j = 0; j < dim; ++j)
      {
        F[i][j] = (i == j ? 1.1 : 0.) + 0.1 * std::sin(1. + 3. * i + j);
        d[i][j] = std::cos(2. + i + j);
      }
  const auto moved = [&](const double size) {
    return point(material, F + size * d * F);
  };
  const auto here = moved(0.), ahead = moved(e), behind = moved(-e);

  const auto tau       = mandel::block<dim>(here.kirchhoff_stress[0]);
  const auto in_mandel = mandel::symmetric_part<dim>(d);
  const auto exact     = here.spatial_tangent[0] * in_mandel +
                     mandel::symmetric_part<dim>(d * tau + tau * transpose(d));
  const auto change =
    (ahead.kirchhoff_stress[0] - behind.kirchhoff_stress[0]) / (2. * e);
  const double work =
    (ahead.stored_energy[0] - behind.stored_energy[0]) / (2. * e);
  return (change - exact).norm() / exact.norm() +
         std::abs(work / (here.kirchhoff_stress[0] * in_mandel) - 1.);
}

template <int dim>
bool
tangent_is_right()
{
  const double coarse = tangent_error<dim>(1e-3),
               fine   = tangent_error<dim>(5e-4);
  std::cout << "in " << dim << " dimensions the error falls "
            << std::round(100. * coarse / fine) / 100.
            << " times when the difference is halved\n";
  return std::abs(coarse / fine - 4.) < 0.01 && fine < 1e-5;
}

// The line of the library: a name for `Model`, words for `--list`, a maker.
template <int dim>
std::unique_ptr<MaterialParameters<dim>>
make(const std::string &section)
{
  return std::make_unique<NeoHookeParameters<dim>>(section);
}

// `--test` asks for the tangent; otherwise this is emmy with one material more:
// all options of the program are there, and messages know the new name.
int
main(int argc, char *argv[])
{
  if (argc == 2 && std::string(argv[1]) == "--test")
    return tangent_is_right<2>() && tangent_is_right<3>() ? 0 : 1;
  material_library<2>().add({"my neo-Hooke", "neo-Hooke elasticity", make<2>});
  material_library<3>().add({"my neo-Hooke", "neo-Hooke elasticity", make<3>});
  return run_program(argc, argv);
}
