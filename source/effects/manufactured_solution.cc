#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/manufactured_solution.h>
#include <emmy/math/kinematics.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  using dealii::Point;
  using dealii::Tensor;

  namespace
  {
    /** Of the load, the start and the errors: they live in different lists. */
    template <int dim>
    using SharedMotion = std::shared_ptr<const ExactMotion<dim>>;

    /** Where a particle was at t = 0. */
    template <int dim>
    Point<dim>
    reference_position(const PointArrays<dim> &points,
                       const unsigned int      component,
                       const std::size_t       p)
    {
      return Point<dim>(points.template get<dim>(component, p));
    }

    /** f_A = sum S_Ap m_p b(X_p, t + dt/2), as the mid-point rule wants it. */
    template <int dim>
    class ExactLoad : public Effect<dim>, public Load<dim>
    {
    public:
      ExactLoad(SharedMotion<dim>                  motion,
                std::vector<const Material<dim> *> material_of_body,
                const unsigned int                 reference,
                const unsigned int                 mass)
        : motion(std::move(motion))
        , material_of_body(std::move(material_of_body))
        , reference(reference)
        , mass(mass)
      {}

      const Load<dim> *
      load() const override
      {
        return this;
      }

      void
      add_load(const StepData<dim> &step,
               std::vector<double> &local_force) const override
      {
        const double *m = step.points.component(mass);
        for (const auto &group : step.stencils.groups)
          {
            const auto b = body_force(step, group);
            for (unsigned int a = 0; a < group.n_nodes; ++a)
              {
                const double  *S = step.stencils.value(group, a);
                Tensor<1, dim> nodal;
                for (unsigned int p = 0; p < group.n_points; ++p)
                  nodal += S[p] * m[group.first_point + p] * b[p];
                const unsigned int node = step.start.active->nodes(group)[a];
                for (unsigned int c = 0; c < dim; ++c)
                  local_force[unknown<dim>(node, c)] += nodal[c];
              }
          }
      }

      void
      add_load_at_points(const StepData<dim> &step,
                         std::vector<double> &point_force) const override
      {
        for (const auto &group : step.stencils.groups)
          {
            const auto b = body_force(step, group);
            for (unsigned int q = 0; q < group.n_points; ++q)
              {
                const std::size_t p = group.first_point + q;
                for (unsigned int c = 0; c < dim; ++c)
                  point_force[dim * p + c] +=
                    step.points.component(mass)[p] * b[q][c];
              }
          }
      }

    private:
      /** b at the points of a group, m/s^2. */
      std::vector<Tensor<1, dim>>
      body_force(const StepData<dim>                 &step,
                 const typename Stencils<dim>::Group &group) const
      {
        std::vector<Point<dim>> X;
        for (unsigned int p = 0; p < group.n_points; ++p)
          X.push_back(
            reference_position(step.points, reference, group.first_point + p));
        return exact_body_force(*motion,
                                *material_of_body[group.body],
                                X,
                                step.time + 0.5 * step.time_step);
      }

      const SharedMotion<dim>                  motion;
      const std::vector<const Material<dim> *> material_of_body;
      const unsigned int                       reference, mass;
    };

    /** Keeps where particles are at the start, and sets their velocities. */
    template <int dim>
    class ExactStart : public Effect<dim>
    {
    public:
      ExactStart(SharedMotion<dim>  motion,
                 const std::string &section,
                 const unsigned int reference,
                 const unsigned int velocity)
        : motion(std::move(motion))
        , section(section)
        , reference(reference)
        , velocity(velocity)
      {}

      std::string
      mark(const BackgroundGrid<dim>               &grid,
           dealii::Particles::ParticleHandler<dim> &particles) const override
      {
        std::string outside, moving;
        for (auto &particle : particles)
          {
            const Point<dim> &X          = particle.get_location();
            const auto        properties = particle.get_properties();
            const std::string where =
              "at (" + dealii::Patterns::Tools::to_string(X) + ") m";
            if (!motion->contains(X))
              outside = "a particle " + where +
                        " is outside of the body that the motion is of, " +
                        motion->body();
            const Tensor<1, dim> v = motion->at(X, 0.).velocity;
            for (unsigned int d = 0; d < dim; ++d)
              {
                if (properties[velocity + d] != 0.)
                  moving = "a particle " + where +
                           " has an initial velocity, but the motion gives it";
                properties[reference + d] = X[d];
                properties[velocity + d]  = v[d];
              }
          }
        throw_together(grid.communicator(),
                       section,
                       outside,
                       "let the shapes of Bodies and the measures in this "
                       "section agree.");
        throw_together(grid.communicator(),
                       section,
                       moving,
                       "remove the bodies' <Initial velocity>.");
        return "exact motion of " + motion->body();
      }

    private:
      const SharedMotion<dim> motion;
      const std::string       section;
      const unsigned int      reference, velocity;
    };

    /** How far particles are from the motion. */
    template <int dim>
    class ExactError : public Effect<dim>, public StepMeasures<dim>
    {
    public:
      ExactError(SharedMotion<dim>  motion,
                 const unsigned int reference,
                 const unsigned int velocity,
                 const unsigned int volume)
        : motion(std::move(motion))
        , reference(reference)
        , velocity(velocity)
        , volume(volume)
      {}

      StepMeasures<dim> *
      measures() override
      {
        return this;
      }

      std::vector<StepMeasure>
      measure(const PointArrays<dim>    &points,
              const double               time,
              const BackgroundGrid<dim> &grid) override
      {
        const MPI_Comm communicator = grid.communicator();
        const double  *V            = points.component(volume);
        double of_position = 0., of_velocity = 0., total = 0., largest = 0.;
        for (std::size_t p = 0; p < points.n_points(); ++p)
          {
            const Point<dim>      X = reference_position(points, reference, p);
            const ExactState<dim> exact = motion->at(X, time);
            const double          square =
              (points.point(p) - X - exact.displacement).norm_square();
            largest = std::max(largest, square);
            of_position += V[p] * square;
            of_velocity +=
              V[p] * (points.template get<dim>(velocity, p) - exact.velocity)
                       .norm_square();
            total += V[p];
          }
        using dealii::Utilities::MPI::max;
        using dealii::Utilities::MPI::sum;
        total = sum(total, communicator);
        return {{"displacement_error",
                 std::sqrt(sum(of_position, communicator) / total)},
                {"displacement_error_largest",
                 std::sqrt(max(largest, communicator))},
                {"velocity_error",
                 std::sqrt(sum(of_velocity, communicator) / total)}};
      }

    private:
      const SharedMotion<dim> motion;
      const unsigned int      reference, velocity, volume;
    };
  } // namespace

  template <int dim>
  std::vector<Tensor<1, dim>>
  exact_body_force(const ExactMotion<dim>        &motion,
                   const Material<dim>           &material,
                   const std::vector<Point<dim>> &points,
                   const double                   time)
  {
    std::vector<Tensor<1, dim>> result;
    // too large for the stack of a thread
    const auto batch = std::make_unique<MaterialBatch<dim>>();
    for (std::size_t first = 0; first < points.size();
         first += max_batch_points)
      {
        batch->n_points =
          std::min<std::size_t>(max_batch_points, points.size() - first);
        std::array<ExactState<dim>, max_batch_points> states;
        for (unsigned int p = 0; p < batch->n_points; ++p)
          {
            states[p] = motion.at(points[first + p], time);
            batch->left_cauchy_green_less_unit[p] =
              left_cauchy_green_less_unit<dim>(states[p].H,
                                               MandelVector<dim>());
          }
        material.evaluate(*batch);
        for (unsigned int p = 0; p < batch->n_points; ++p)
          {
            const Tensor<2, dim> I = dealii::unit_symmetric_tensor<dim>();
            const Tensor<2, dim> F_inverse = invert(I + states[p].H);
            const Tensor<2, dim> tau =
              mandel::block<dim>(batch->kirchhoff_stress[p]);
            Tensor<1, dim> divergence;
            for (unsigned int J = 0; J < dim; ++J)
              {
                const Tensor<2, dim> l = states[p].F_gradient[J] * F_inverse;
                const Tensor<2, dim> stress_change =
                  mandel::block<dim>(batch->spatial_tangent[p] *
                                     mandel::symmetric_part<dim>(l)) +
                  l * tau;
                divergence += stress_change * F_inverse[J];
              }
            result.push_back(states[p].acceleration -
                             divergence / material.density());
          }
      }
    return result;
  }

  template <int dim>
  ManufacturedSolutionParameters<dim>::ManufacturedSolutionParameters(
    const std::string &section)
    : EffectParameters<dim>(section)
    , vibration(section + "/vibration")
    , vortex(section + "/vortex")
  {
    this->add_parameter(
      "Motion",
      motion,
      "vibration: a box between rollers vibrates along the axes. vortex: a "
      "ring, free at its radii, is wrung to and fro. Each has a subsection of "
      "its name. The body force follows from the motion; the ledger says how "
      "far particles are from it.",
      this->prm,
      dealii::Patterns::Selection("vibration|vortex"));
    this->add_parameter("Period",
                        period,
                        "Of the motion, which is proportional to sin(2 pi "
                        "t/period). Unit: s. Required, positive.",
                        this->prm,
                        dealii::Patterns::Double(0.));
  }

  template <int dim>
  void
  ManufacturedSolutionParameters<dim>::add_to(Effects<dim> &effects,
                                              FieldLayout  &layout) const
  {
    AssertThrow(period > 0.,
                ExcParameter(this->path(),
                             "Period",
                             shortest(period),
                             "it is required and must be positive (s)."));
    for (const Material<dim> *material : effects.material_of_body)
      AssertThrow(material->history().empty() && material->parameters().empty(),
                  ExcParameter("Effects",
                               "Names",
                               "manufactured solution",
                               "it needs bodies of an elastic material, e.g. "
                               "Hencky, that is the same everywhere: the "
                               "stress of others depends on what was before, "
                               "or on where a particle was."));
    const double            omega = 2. * dealii::numbers::PI / period;
    const SharedMotion<dim> exact =
      motion == "vibration" ? vibration.make(omega) : vortex.make(omega);
    const unsigned int reference = layout.add(card().fields[0]);
    const unsigned int velocity  = layout["velocity"];
    effects.terms.push_back(std::make_unique<ExactLoad<dim>>(
      exact, effects.material_of_body, reference, layout["mass"]));
    effects.terms.push_back(std::make_unique<ExactStart<dim>>(
      exact, this->path(), reference, velocity));
    effects.terms.push_back(std::make_unique<ExactError<dim>>(
      exact, reference, velocity, layout["reference_volume"]));
  }

  template <int dim>
  EffectCard
  ManufacturedSolutionParameters<dim>::card()
  {
    EffectCard card;
    card.enters         = "loads of the step, before Newton; accounts: errors";
    card.fields         = {{"reference_position",
                            Field::Kind::vector,
                            "m",
                            "position at the start of the run"}};
    card.ledger_columns = {"load_work",
                           "displacement_error",
                           "displacement_error_largest",
                           "velocity_error"};
    return card;
  }

#define INSTANTIATE(dim)                                      \
  template class ManufacturedSolutionParameters<dim>;         \
  template std::vector<Tensor<1, dim>> exact_body_force<dim>( \
    const ExactMotion<dim> &,                                 \
    const Material<dim> &,                                    \
    const std::vector<Point<dim>> &,                          \
    const double);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
