// A material from outside emmy: compressible neo-Hooke elasticity,
//   psi = G/2 (tr b - 3 - 2 ln J) + lambda/2 (ln J)^2.
// The program is emmy with one more value of <Model>: neo-Hooke.

#include <emmy/material/hencky.h>
#include <emmy/study/program.h>

using namespace emmy;

template <int dim>
class NeoHooke : public Material<dim>
{
public:
  explicit NeoHooke(const ElasticConstants &constants)
    : constants(constants)
    , G(constants.shear_modulus)
    , lambda(constants.bulk_modulus - 2. / 3. * G)
  {}

  void
  evaluate(MaterialBatch<dim> &batch) const override
  {
    const auto I = mandel::unit<dim>();
    for (unsigned int p = 0; p < batch.n_points; ++p)
      {
        const auto &b = batch.left_cauchy_green[p];
        // in plane strain b is a tensor in three dimensions too; b[3] is b_33
        const double det_b =
          dealii::determinant(mandel::block<dim>(b)) * (dim == 2 ? b[3] : 1.);
        const double ln_J = 0.5 * std::log(det_b);

        batch.kirchhoff_stress[p] = G * (b - I) + lambda * ln_J * I;
        batch.stored_energy[p] =
          0.5 * G * (b * I - 3. - 2. * ln_J) + 0.5 * lambda * ln_J * ln_J;
        if (batch.with_tangent)
          {
            // in Mandel notation the symmetric identity is the unit matrix
            batch.spatial_tangent[p] = lambda * outer_product(I, I);
            for (unsigned int i = 0; i < n_mandel<dim>; ++i)
              batch.spatial_tangent[p][i][i] += 2. * (G - lambda * ln_J);
          }
      }
  }

  double
  density() const override
  {
    return constants.density;
  }

  double
  p_wave_modulus() const override
  {
    return lambda + 2. * G;
  }

private:
  const ElasticConstants constants;
  const double           G, lambda;
};

/** Its section in a parameter file: density and two elastic constants. */
template <int dim>
class NeoHookeParameters : public MaterialParameters<dim>
{
public:
  explicit NeoHookeParameters(const std::string &section)
    : MaterialParameters<dim>(section)
  {
    constants.add_to(*this);
  }

  std::unique_ptr<Material<dim>>
  make() const override
  {
    return std::make_unique<NeoHooke<dim>>(constants.completed(this->path()));
  }

private:
  ElasticConstants constants;
};

template <int dim>
void
add_neo_hooke()
{
  material_library<dim>().add(
    {"neo-Hooke",
     "compressible neo-Hooke elasticity",
     [](const std::string &section) {
       return std::make_unique<NeoHookeParameters<dim>>(section);
     }});
}

int
main(int argc, char *argv[])
{
  add_neo_hooke<2>();
  add_neo_hooke<3>();
  return run_program(argc, argv);
}
