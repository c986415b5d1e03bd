// Facts about manufactured solutions: the body force is the one that
// automatic differentiation finds from the positions alone; displacements
// converge with second order in time and space; what the load puts in is in
// the ledger; ranks agree.

#include <emmy/effects/manufactured_solution.h>
#include <emmy/material/hencky.h>

#include <map>
#include <random>

#include "../scene.h"

#ifdef DEAL_II_TRILINOS_WITH_SACADO
#  include <Sacado.hpp>
#endif

using namespace emmy;
using dealii::Point;
using dealii::Tensor;
using dealii::numbers::PI;
using test::check;

namespace
{
  constexpr double period = 0.7, omega = 2. * PI / period;

  ElasticConstants
  constants()
  {
    ElasticConstants result;
    result.density       = 3.;
    result.young_modulus = 100.;
    result.poisson_ratio = 0.3;
    return result.completed("test");
  }

  /** Parameters of a motion, made from text. */
  template <class Parameters>
  auto
  make_motion(const std::string &entries)
  {
    dealii::ParameterAcceptor::clear();
    Parameters parameters("motion");
    parameters.prm.parse_input_from_string("subsection motion\n" + entries +
                                           "end\n");
    parameters.parse_all_parameters();
    return parameters.make(omega);
  }

#ifdef DEAL_II_TRILINOS_WITH_SACADO
  template <typename Number>
  using Vector3 = std::array<Number, 3>;
  template <typename Number>
  using Matrix3 = std::array<Vector3<Number>, 3>;

  template <typename Number>
  Matrix3<Number>
  combine(const double           a,
          const Matrix3<Number> &A,
          const double           b,
          const Matrix3<Number> &B)
  {
    Matrix3<Number> C;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        C[i][j] = a * A[i][j] + b * B[i][j];
    return C;
  }

  /** A B or, if transposed, A B^T. */
  template <typename Number>
  Matrix3<Number>
  product(const Matrix3<Number> &A,
          const Matrix3<Number> &B,
          const bool             transposed = false)
  {
    Matrix3<Number> C;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        {
          C[i][j] = 0.;
          for (unsigned int k = 0; k < 3; ++k)
            C[i][j] += A[i][k] * (transposed ? B[j][k] : B[k][j]);
        }
    return C;
  }

  template <typename Number>
  Matrix3<Number>
  inverse(const Matrix3<Number> &A)
  {
    Matrix3<Number> C; // adjugate by cyclic cofactors
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        C[j][i] = A[(i + 1) % 3][(j + 1) % 3] * A[(i + 2) % 3][(j + 2) % 3] -
                  A[(i + 1) % 3][(j + 2) % 3] * A[(i + 2) % 3][(j + 1) % 3];
    const Number determinant =
      A[0][0] * C[0][0] + A[0][1] * C[1][0] + A[0][2] * C[2][0];
    for (auto &row : C)
      for (Number &entry : row)
        entry /= determinant;
    return C;
  }

  template <typename Number>
  Matrix3<Number>
  identity()
  {
    Matrix3<Number> I;
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        I[i][j] = i == j ? 1. : 0.;
    return I;
  }

  /**
   * ln b without its spectrum: square roots by the iteration of Denman and
   * Beavers until b is close to I, then the series of 2 artanh.
   */
  template <typename Number>
  Matrix3<Number>
  logarithm(Matrix3<Number> b)
  {
    const Matrix3<Number>  I       = identity<Number>();
    constexpr unsigned int n_roots = 4;
    for (unsigned int root = 0; root < n_roots; ++root)
      {
        Matrix3<Number> Z = I;
        for (unsigned int i = 0; i < 10; ++i)
          {
            const Matrix3<Number> inverse_b = inverse(b);
            b                               = combine(0.5, b, 0.5, inverse(Z));
            Z                               = combine(0.5, Z, 0.5, inverse_b);
          }
      }
    const Matrix3<Number> z =
      product(combine(1., b, -1., I), inverse(combine(1., b, 1., I)));
    const Matrix3<Number> z2  = product(z, z);
    Matrix3<Number>       sum = combine(0., I, 0., I), power = z;
    for (unsigned int k = 1; k < 30; k += 2)
      {
        sum   = combine(1., sum, 2. * (1 << n_roots) / k, power);
        power = product(power, z2);
      }
    return sum;
  }

  using First  = Sacado::Fad::DFad<double>;
  using Second = Sacado::Fad::DFad<First>;

  /** Independent variable number @p i of n, for two derivatives. */
  Second
  independent(const unsigned int n, const unsigned int i, const double value)
  {
    Second result(n, i, First(n, i, value));
    return result;
  }

  /**
   * b = a - Div P/rho_0 from x(X, t) alone.
   * @param x the motion
   */
  template <int dim, class Position>
  Tensor<1, dim>
  automatic_body_force(const Position         &x,
                       const ElasticConstants &material,
                       const Point<dim>       &X,
                       const double            time)
  {
    Vector3<Second> moving, still;
    for (unsigned int J = 0; J < 3; ++J)
      {
        moving[J] = J < dim ? X[J] : 0.;
        still[J]  = independent(3, J, J < dim ? X[J] : 0.);
      }
    const Vector3<Second> of_time = x(moving, independent(1, 0, time)),
                          of_X    = x(still, Second(time));

    Matrix3<First> F = identity<First>();
    for (unsigned int i = 0; i < dim; ++i)
      for (unsigned int J = 0; J < dim; ++J)
        F[i][J] = of_X[i].dx(J);
    Matrix3<First> tau   = logarithm(product(F, F, true)); // 2 e
    const First    trace = 0.5 * (tau[0][0] + tau[1][1] + tau[2][2]);
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int j = 0; j < 3; ++j)
        {
          tau[i][j] *= material.shear_modulus;
          if (i == j)
            tau[i][j] +=
              (material.bulk_modulus - 2. / 3. * material.shear_modulus) *
              trace;
        }
    const Matrix3<First> P = product(tau, inverse(F), true);
    Tensor<1, dim>       b;
    for (unsigned int i = 0; i < dim; ++i)
      {
        b[i] = of_time[i].dx(0).dx(0);
        for (unsigned int J = 0; J < dim; ++J)
          b[i] -= P[i][J].dx(J) / material.density;
      }
    return b;
  }

  /** The largest deviation from it at random points and times, relative. */
  template <int dim, class Position>
  void
  check_force(const ExactMotion<dim> &motion,
              const Position         &x,
              const Point<dim>       &lower,
              const Point<dim>       &upper,
              const std::string      &name)
  {
    const Hencky<dim>                      material(constants());
    std::mt19937                           generator(7);
    std::uniform_real_distribution<double> random(0., 1.);
    double                                 error = 0., strain = 0.;
    unsigned int                           n_points = 0;
    while (n_points < 60)
      {
        Point<dim> X;
        for (unsigned int d = 0; d < dim; ++d)
          X[d] = lower[d] + random(generator) * (upper[d] - lower[d]);
        if (!motion.contains(X))
          continue;
        ++n_points;
        const double time = period * random(generator);
        const auto   b    = exact_body_force(motion, material, {X}, time)[0];
        const auto   automatic = automatic_body_force(x, constants(), X, time);
        error = std::max(error, (b - automatic).norm() / automatic.norm());
        const auto                   state = motion.at(X, time);
        const dealii::Tensor<2, dim> I = dealii::unit_symmetric_tensor<dim>();
        strain =
          std::max(strain, (transpose(I + state.H) * (I + state.H)).norm());

        // what is not in the force, but in the ledger
        Vector3<Second> moving;
        for (unsigned int d = 0; d < 3; ++d)
          moving[d] = d < dim ? X[d] : 0.;
        const auto position = x(moving, independent(1, 0, time));
        for (unsigned int d = 0; d < dim; ++d)
          {
            test::check_close(X[d] + state.displacement[d],
                              position[d].val().val(),
                              1e-14,
                              name + ": position");
            test::check_close(state.velocity[d],
                              position[d].val().dx(0),
                              1e-13 * omega,
                              name + ": velocity");
          }
      }
    std::cout << name << ", largest |F^T F| " << strain << '\n';
    test::at_most(name + ": error of the body force, relative", error, 1e-10);
  }

  template <int dim>
  void
  check_forces()
  {
    const std::string dimension = std::to_string(dim) + "D";
    const bool        is_space  = dim == 3;
    const double      lower[3] = {-0.5, 0.2, 1.}, edge[3] = {1., 2., 0.7},
                 amplitude[3] = {0.2, -0.15, 0.1};
    Point<dim> from, to;
    for (unsigned int d = 0; d < dim; ++d)
      {
        from[d] = lower[d];
        to[d]   = lower[d] + edge[d];
      }
    check_force<dim>(
      *make_motion<VibrationParameters<dim>>(
        std::string("set Lower corner = -0.5, 0.2") + (is_space ? ", 1" : "") +
        "\nset Upper corner = 0.5, 2.2" + (is_space ? ", 1.7" : "") +
        "\nset Amplitude = 0.2, -0.15" + (is_space ? ", 0.1" : "") + "\n"),
      [&](const Vector3<Second> &X, const Second &t) {
        Vector3<Second> x = X;
        for (unsigned int d = 0; d < dim; ++d)
          x[d] += amplitude[d] * sin(PI / edge[d] * (X[d] - lower[d])) *
                  sin(omega * t);
        return x;
      },
      from,
      to,
      dimension + ", vibration");

    // in polar coordinates, where it is a sum
    const double inner = 0.7, outer = 1.2, height = 0.9;
    from[0] = -outer + 0.1;
    to[0]   = outer + 0.1;
    from[1] = -outer - 0.3;
    to[1]   = outer - 0.3;
    if (is_space)
      {
        from[dim - 1] = 0.4;
        to[dim - 1]   = 0.4 + height;
      }
    check_force<dim>(
      *make_motion<VortexParameters<dim>>(
        std::string("set Center = 0.1, -0.3") + (is_space ? ", 0.4" : "") +
        "\nset Inner radius = 0.7\nset Outer radius = 1.2\nset Angle = 0.4\n" +
        (is_space ? "set Height = 0.9\n" : "")),
      [&](const Vector3<Second> &X, const Second &t) {
        const Second u = X[0] - 0.1, v = X[1] + 0.3;
        const Second R     = sqrt(u * u + v * v);
        const Second s     = (2. * R - inner - outer) / (outer - inner);
        Second       angle = 0.4 * sin(omega * t) * (1. - s * s) * (1. - s * s);
        if (is_space)
          angle *= cos(PI / height * (X[2] - 0.4));
        angle += atan2(v, u);
        return Vector3<Second>{
          {0.1 + R * cos(angle), -0.3 + R * sin(angle), X[2]}};
      },
      from,
      to,
      dimension + ", vortex");
  }
#endif

  ParameterFile
  vibration(const std::string &folder,
            const std::string &cells,
            const std::string &step,
            const std::string &end)
  {
    ParameterFile file(folder + "/vibration.prm");
    file.set("Grid/Cells=" + cells);
    file.set("Time/Step size=" + step);
    file.set("Time/End time=" + end);
    file.set("Solver/Newton tolerance=1e-15");
    return file;
  }

  /** The rate at which an error falls when h or dt is halved. */
  double
  order(const double coarse, const double fine)
  {
    return std::log2(coarse / fine);
  }

  /** Ends a run at @p end and checks what holds for each. */
  std::unique_ptr<test::RunningScene<2>>
  run_to_end(const ParameterFile &file, const double end)
  {
    const SceneParameters<2> parameters(file);
    auto run = std::make_unique<test::RunningScene<2>>(parameters);
    check(run->ledger["displacement_error"] == 0. &&
            run->ledger["velocity_error"] == 0.,
          "the start is exact");
    run->advance_to((1. - 1e-9) * end);
    double scale = test::largest(run->column("kinetic_energy"));
    check(std::abs(run->ledger["balance_error"]) < 1e-12 * scale,
          "the work of the load is in the ledger");
    return run;
  }

  void
  check_order_in_time(const std::string &folder)
  {
    std::vector<double> errors;
    for (const char *step : {"0.00125", "0.000625", "0.0003125"})
      errors.push_back(
        run_to_end(vibration(folder, "24, 24", step, "0.01"), 0.01)
          ->ledger["displacement_error"]);
    for (unsigned int i = 0; i < 2; ++i)
      {
        const double p = order(errors[i], errors[i + 1]);
        std::cout << "order in time " << p << '\n';
        check(p > 1.9 && p < 2.1, "second order in time");
      }
  }

  /** Loads act when the stress does: else these errors are 2e-3 and 1e-3. */
  void
  check_explicit(const std::string &folder)
  {
    for (const char *step : {"0.0004", "0.0002"})
      {
        ParameterFile file = vibration(folder, "24, 24", step, "0.01");
        file.set("Time/Integrator=explicit");
        const double error =
          run_to_end(file, 0.01)->ledger["displacement_error"];
        std::cout << "explicit, step " << step << " s: error " << error << '\n';
        check(error < 8e-4, "the error of explicit steps is that of the grid");
      }
  }

  void
  check_order_in_space(const std::string &folder)
  {
    std::vector<double> errors;
    for (const char *cells : {"6, 6", "12, 12", "24, 24"})
      errors.push_back(
        run_to_end(vibration(folder, cells, "0.0001", "0.0025"), 0.0025)
          ->ledger["displacement_error"]);
    for (unsigned int i = 0; i < 2; ++i)
      {
        const double p = order(errors[i], errors[i + 1]);
        std::cout << "order in space " << p << '\n';
        check(p > 1.8, "second order in space");
      }
  }

  template <int dim>
  void
  compare(const ParameterFile &file,
          const unsigned int   n_steps,
          const std::string   &name)
  {
    test::compare_ranks<dim>(file,
                             n_steps,
                             name,
                             {"time",
                              "kinetic_energy",
                              "strain_energy",
                              "load_work",
                              "displacement_error",
                              "displacement_error_largest",
                              "velocity_error"});
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string                        folder = argv[1];
  if (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) > 1)
    {
      compare<2>(vibration(folder, "8, 8", "0.0005", "1"), 10, "vibration");
      ParameterFile vortex(folder + "/vortex-3d.prm");
      vortex.set("Grid/Cells=12, 12, 4");
      compare<3>(vortex, 3, "vortex in space");
      return test::report();
    }
#ifdef DEAL_II_TRILINOS_WITH_SACADO
  check_forces<2>();
  check_forces<3>();
#else
  std::cout << "without Sacado: body forces are not checked\n";
#endif
  check_order_in_time(folder);
  check_explicit(folder);
  check_order_in_space(folder);
  return test::report();
}
