#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/surface_loads.h>
#include <emmy/math/divided_volume.h>

#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numeric>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** The area of a face of a box with normal along @p d, m^(dim-1). */
    template <int dim>
    double
    face_area(const Tensor<1, dim> &half_length, const unsigned int d)
    {
      double area = 1.;
      for (unsigned int e = 0; e < dim; ++e)
        area *= e == d ? 1. : 2. * half_length[e];
      return area;
    }

    template <int dim>
    constexpr double
    all_faces()
    {
      return (1u << 2 * dim) - 1.;
    }

    template <int dim, class Number>
    using Matrix2 = Tensor<2, dim, Number>;

    template <int dim, class Number>
    Number
    determinant_of(const Matrix2<dim, Number> &T)
    {
      const auto cof = cofactor_of(T);
      Number     det = 0.;
      for (unsigned int j = 0; j < dim; ++j)
        det += T[0][j] * cof[0][j];
      return det;
    }

    /** T + 1, with the same kind of numbers. */
    template <int dim, class Number>
    Matrix2<dim, Number>
    plus_unit(Matrix2<dim, Number> T)
    {
      for (unsigned int d = 0; d < dim; ++d)
        T[d][d] += 1.;
      return T;
    }

    /** What a pressure of 1 does to a particle: f and f (x) a. */
    template <int dim>
    struct UnitPressure
    {
      const CornerMotion<dim>                            &particle;
      const std::vector<typename LoadedFaces<dim>::Face> &faces;
      bool                                                is_whole, at_middle;
      double volume; ///< at t, m^dim

      template <class Number>
      std::array<Number, dim *(dim + 1)>
      operator()(const Matrix2<dim, Number> &L) const
      {
        std::array<Number, dim *(dim + 1)> result{};
        // Z, and H = dF - I of the step
        Matrix2<dim, Number> Z = plus_unit(Number(0.5) * L), H = L;
        if (at_middle)
          {
            const auto from_start = plus_unit(Number(-0.5) * L);
            Z = transpose(cofactor_of(from_start)) / determinant_of(from_start);
            H = L * Z;
          }
        if (is_whole)
          {
            const auto dF = plus_unit(H);
            auto       A  = transpose(dF) * dF;
            const auto j  = determinant_of(dF);
            for (unsigned int d = 0; d < dim; ++d)
              A[d][d] -= 1.;
            Matrix2<dim, Number> M =
              Z * divided_volume(A, j) * Number(-2. * volume);
            if (at_middle)
              M = M * transpose(Z);
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int d = 0; d < dim; ++d)
                result[(dim + 1) * i + 1 + d] = M[i][d];
            return result;
          }
        Matrix2<dim, Number> F_old = particle.F_old;
        const auto           F     = Z * F_old;
        const auto           cof   = cofactor_of(F);
        const auto          &carry = at_middle ? F : F_old;
        for (const auto &face : faces)
          for (unsigned int i = 0; i < dim; ++i)
            {
              Number f = 0.;
              for (unsigned int e = 0; e < dim; ++e)
                f -= cof[i][e] * face.area[e];
              result[(dim + 1) * i] += f;
              for (unsigned int d = 0; d < dim; ++d)
                for (unsigned int e = 0; e < dim; ++e)
                  result[(dim + 1) * i + 1 + d] +=
                    f * carry[d][e] * face.arm[e];
            }
        return result;
      }
    };
  } // namespace

  template <int dim>
  LoadedFaces<dim>::LoadedFaces(
    const Fields                                 &fields,
    std::shared_ptr<const SurfaceLoadChoice<dim>> choice,
    const std::vector<Tensor<1, dim>>            &half_length_of_body)
    : fields(fields)
    , choice(std::move(choice))
    , half_length_of_body(half_length_of_body)
  {}

  template <int dim>
  bool
  LoadedFaces<dim>::may_hold(
    const dealii::Particles::ParticleAccessor<dim> &particle) const
  {
    return !choice->region ||
           choice->region->value(particle.get_location()) > 0.;
  }

  template <int dim>
  std::array<long, dim>
  LoadedFaces<dim>::row_of(
    const dealii::Particles::ParticleAccessor<dim> &particle) const
  {
    const unsigned int    body = particle.get_properties()[fields.body];
    const auto           &l    = half_length_of_body[body];
    std::array<long, dim> row{};
    row[0]         = body;
    unsigned int i = 1;
    // a third of a spacing off: places on the lattice never lie between two
    // rows
    for (unsigned int d = 0; d < dim; ++d)
      if (d != choice->side / 2)
        row[i++] =
          std::lround(particle.get_location()[d] / (2. * l[d]) - 1. / 3.);
    return row;
  }

  template <int dim>
  std::string
  LoadedFaces<dim>::mark(
    const BackgroundGrid<dim>               &grid,
    dealii::Particles::ParticleHandler<dim> &particles) const
  {
    using Row             = std::array<long, dim>;
    const bool   is_whole = choice->side == choice->whole;
    const double sign     = choice->side % 2 ? 1. : -1.;
    const auto   along    = [&](const auto &particle) {
      return sign * particle.get_location()[choice->side / 2];
    };
    std::map<Row, double> outermost;
    if (!is_whole)
      {
        for (const auto &particle : particles)
          if (may_hold(particle))
            {
              const auto found =
                outermost.emplace(row_of(particle), along(particle)).first;
              found->second = std::max(found->second, along(particle));
            }
        // of the last ones of all ranks
        const std::vector<std::pair<Row, double>> own(outermost.begin(),
                                                      outermost.end());
        for (const auto &rows :
             dealii::Utilities::MPI::all_gather(grid.communicator(), own))
          for (const auto &[row, place] : rows)
            {
              const auto found = outermost.find(row);
              if (found != outermost.end())
                found->second = std::max(found->second, place);
            }
      }
    double        area = 0.;
    std::uint64_t n    = 0;
    for (auto &particle : particles)
      {
        const unsigned int body = particle.get_properties()[fields.body];
        const auto        &l    = half_length_of_body[body];
        double             bits = 0.;
        if (is_whole)
          bits = may_hold(particle) ? all_faces<dim>() : 0.;
        else if (may_hold(particle) &&
                 along(particle) >
                   outermost.at(row_of(particle)) - l[choice->side / 2])
          {
            bits = 1u << choice->side;
            area += face_area(l, choice->side / 2);
          }
        n += bits != 0.;
        particle.get_properties()[fields.faces] = bits;
      }
    n    = dealii::Utilities::MPI::sum(n, grid.communicator());
    area = dealii::Utilities::MPI::sum(area, grid.communicator());
    AssertThrow(n > 0,
                ExcRun(choice->section,
                       "no particle is in its Region at the start",
                       "write a formula in " +
                         dealii::FunctionParser<dim>::default_variable_names() +
                         " that is positive at the surface that holds the "
                         "load, e.g. if(x < 1, 1, -1)."));
    std::string text = "surface load <" + choice->name + ">: ";
    if (is_whole)
      return text + "all around " + std::to_string(n) + " particles";
    text += std::to_string(n) + " faces, " + brief(area) +
            (dim == 2 ? " m" : " m^2") + ", resultant ";
    Tensor<1, dim> resultant = area * choice->traction;
    if (choice->follows)
      resultant[choice->side / 2] = -sign * area * choice->pressure;
    for (unsigned int d = 0; d < dim; ++d)
      text += (d > 0 ? "; " : "") + brief(resultant[d]);
    return text + (dim == 2 ? " N/m" : " N") + " times its amplitude";
  }

  template <int dim>
  std::vector<typename LoadedFaces<dim>::Face>
  LoadedFaces<dim>::of(const PointArrays<dim> &points,
                       const std::size_t       p) const
  {
    std::vector<Face>  result;
    const unsigned int bits = points.component(fields.faces)[p];
    if (bits == 0)
      return result;
    const unsigned int body = points.component(fields.body)[p];
    const auto        &l    = half_length_of_body[body];
    for (unsigned int side = 0; side < 2 * dim; ++side)
      if (bits >> side & 1)
        {
          const unsigned int d    = side / 2;
          const double       sign = side % 2 ? 1. : -1.;
          Face               face;
          face.arm[d]  = sign * l[d];
          face.area[d] = sign * face_area(l, d);
          result.push_back(face);
        }
    return result;
  }

  template <int dim>
  Traction<dim>::Traction(LoadedFaces<dim> faces)
    : faces(std::move(faces))
  {}

  template <int dim>
  std::string
  Traction<dim>::mark(const BackgroundGrid<dim>               &grid,
                      dealii::Particles::ParticleHandler<dim> &particles) const
  {
    return faces.mark(grid, particles);
  }

  template <int dim>
  void
  Traction<dim>::add_load(const StepData<dim> &step,
                          std::vector<double> &local_force) const
  {
    const auto t = faces.choice->amplitude->over(step.time, step.time_step) *
                   faces.choice->traction;
    for (const auto &group : step.stencils.groups)
      for (unsigned int q = 0; q < group.n_points; ++q)
        {
          const std::size_t p = group.first_point + q;
          for (const auto &face : faces.of(step.points, p))
            {
              const Tensor<1, dim> force = face.area.norm() * t;
              const Tensor<1, dim> arm =
                tensor_field(step.points,
                             faces.fields.deformation_gradient,
                             p) *
                face.arm;
              for (unsigned int a = 0; a < group.n_nodes; ++a)
                {
                  double weight = step.stencils.value(group, a)[q];
                  for (unsigned int d = 0; d < dim; ++d)
                    weight += step.stencils.gradient(group, a, d)[q] * arm[d];
                  const unsigned int node = step.start.active->nodes(group)[a];
                  for (unsigned int c = 0; c < dim; ++c)
                    local_force[unknown<dim>(node, c)] += weight * force[c];
                }
            }
        }
  }

  template <int dim>
  void
  Traction<dim>::add_load_at_points(const StepData<dim> &step,
                                    std::vector<double> &point_force) const
  {
    const auto t = faces.choice->amplitude->over(step.time, step.time_step) *
                   faces.choice->traction;
    for (std::size_t p = 0; p < step.points.n_points(); ++p)
      for (const auto &face : faces.of(step.points, p))
        for (unsigned int c = 0; c < dim; ++c)
          point_force[dim * p + c] += face.area.norm() * t[c];
  }

  template <int dim>
  Pressure<dim>::Pressure(LoadedFaces<dim> faces)
    : faces(std::move(faces))
  {}

  template <int dim>
  std::string
  Pressure<dim>::mark(const BackgroundGrid<dim>               &grid,
                      dealii::Particles::ParticleHandler<dim> &particles) const
  {
    return faces.mark(grid, particles);
  }

  template <int dim>
  std::string
  Pressure<dim>::add(const StepData<dim> &step,
                     const Iterate<dim>  &iterate,
                     Vector              &force,
                     Matrix              *jacobian) const
  {
    add_forces(
      step, iterate.local_displacement, force, jacobian, &iterate.trial);
    return "";
  }

  template <int dim>
  void
  Pressure<dim>::add_forces(const StepData<dim>       &step,
                            const std::vector<double> &u,
                            Vector                    &force,
                            Matrix                    *jacobian,
                            PointArrays<dim>          *trial) const
  {
    using Complex  = std::complex<double>;
    const double p = faces.choice->pressure *
                     faces.choice->amplitude->over(step.time, step.time_step);
    CornerForces<dim>          forces(step, u, jacobian);
    const ParticleCorners<dim> corners{};
    for (const auto &group : step.stencils.groups)
      {
        for (unsigned int q = 0; q < group.n_points; ++q)
          {
            const auto here = faces.of(step.points, group.first_point + q);
            if (here.empty() && !trial)
              continue;
            const auto particle = corner_motion(
              step, group, q, u, corners, faces.fields.deformation_gradient);
            for (unsigned int i = 0; trial && i < dim; ++i)
              for (unsigned int j = 0; j < dim; ++j) // nobody else may keep it
                trial->component(faces.fields.deformation_gradient + dim * i +
                                 j)[particle.p] = particle.F_new()[i][j];
            if (here.empty())
              continue;
            const bool              is_whole = here.size() == 2 * dim;
            const UnitPressure<dim> unit_pressure{
              particle,
              here,
              is_whole,
              step.stencils.at_middle,
              (is_whole ? 2. * here[0].arm.norm() * here[0].area.norm() : 0.) *
                determinant(particle.F_old)};
            PointMotion<dim> value = unit_pressure(particle.gradient);
            for (double &v : value)
              v *= p;
            std::array<PointMotion<dim>, dim *(dim + 1)> by_motion{};
            // a step into the imaginary numbers has no cancellation
            constexpr double        tiny = 1e-30;
            Tensor<2, dim, Complex> L;
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int j = 0; j < dim; ++j)
                L[i][j] = particle.gradient[i][j];
            for (unsigned int j = 0; jacobian && j < dim; ++j)
              for (unsigned int m = 0; m < dim; ++m)
                {
                  L[j][m] += Complex(0., tiny);
                  const auto moved = unit_pressure(L);
                  L[j][m] -= Complex(0., tiny);
                  for (unsigned int row = 0; row < moved.size(); ++row)
                    by_motion[row][(dim + 1) * j + 1 + m] =
                      p * moved[row].imag() / tiny;
                }
            forces.add(value, by_motion);
            forces.finish(group, q);
          }
        forces.finish(group);
      }
    forces.finish(force);
  }

  template <int dim>
  std::vector<EnergyEntry>
  Pressure<dim>::energies(const StepData<dim> &step,
                          const Vector        &displacement,
                          const PointArrays<dim> &) const
  {
    const ActiveGrid<dim> &active = *step.start.active;
    const auto             u      = active.to_local(displacement);
    Vector                 force  = active.make_vector();
    add_forces(step, u, force, nullptr, nullptr);
    auto entries = energy_entries();
    // the force is that on the residual: the load with the other sign
    entries[0].change =
      -(force * displacement) /
      dealii::Utilities::MPI::n_mpi_processes(active.communicator());
    return entries;
  }

  template <int dim>
  std::vector<EnergyEntry>
  Pressure<dim>::energy_entries() const
  {
    return {{"pressure_" + faces.choice->name + "_work",
             EnergyEntry::Kind::work,
             0.}};
  }

  template class LoadedFaces<2>;
  template class LoadedFaces<3>;
  template class Traction<2>;
  template class Traction<3>;
  template class Pressure<2>;
  template class Pressure<3>;
} // namespace emmy
