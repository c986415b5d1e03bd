#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/step/step_rule.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace emmy
{
  namespace
  {
    using dealii::Patterns::Double;
    using dealii::Patterns::Integer;

    // negative numbers pass the patterns so that validate() can explain them
    void
    declare_integrator(TimeParameters &time)
    {
      time.add_parameter("End time",
                         time.end_time,
                         "The run ends at the first step that reaches it (see "
                         "<Shorten last step>). Unit: s. "
                         "Required, positive.",
                         time.prm,
                         Double());
      time.add_parameter(
        "Integrator",
        time.integrator,
        "implicit: Newton, no limit on the step but accuracy. "
        "explicit: lumped mass, symplectic Euler, stress updated "
        "last; for comparison. Cheap steps, which are stable only "
        "for a Factor below about 1 (the Courant number) and are "
        "never halved; GIMP is more robust than linear. static: no "
        "inertia; loads are raised in <Increments> until the end "
        "time, which only counts them, and bodies are where forces "
        "balance.",
        time.prm,
        dealii::Patterns::Selection("implicit|explicit|static"));
      time.add_parameter(
        "Increments",
        time.increments,
        "Of static steps: equal parts in which loads are raised. One "
        "that fails is halved. At least 1.",
        time.prm,
        Integer(1));
      time.add_parameter(
        "Raised loads",
        time.raised_loads,
        "Of static steps: those of Effects/Names whose loads are "
        "raised. Others act in full from the start, as the weight of "
        "bodies that are at rest under it already. none: all act in "
        "full. Empty: all are raised.",
        time.prm,
        dealii::Patterns::List(dealii::Patterns::Anything()));
      time.add_parameter(
        "Stress update",
        time.stress_update,
        "Of explicit steps: what strains the particles at the end of "
        "the step. modified: the velocities that they have then, "
        "mapped to the grid again. plain: the velocities of the "
        "grid, which are wild where a node has little mass: it "
        "fails when particles enter new cells.",
        time.prm,
        dealii::Patterns::Selection("modified|plain"));
    }

    void
    declare_steps(TimeParameters &time)
    {
      time.add_parameter(
        "Step rule",
        time.step_rule,
        "fixed: <Step size>. wave: time of a P-wave through a cell "
        "(Pretti et al. 2023, eq. 57). paper: eq. 61 as printed, "
        "from nodal sums. normalised: the same with averaged moduli.",
        time.prm,
        dealii::Patterns::Selection("fixed|wave|paper|normalised"));
      time.add_parameter("Step size",
                         time.step_size,
                         "Step of the rule <fixed>. Unit: s.",
                         time.prm,
                         Double());
      time.add_parameter(
        "Factor",
        time.factor,
        "Multiplies the rules wave, paper and normalised. 0.2 to "
        "0.5 resolves waves; more is stable, but coarse. "
        "Dimensionless, positive.",
        time.prm,
        Double());
      time.add_parameter("Maximum steps",
                         time.maximum_steps,
                         "The run ends after so many steps. 0: no limit.",
                         time.prm,
                         Integer(0));
      time.add_parameter(
        "Maximum halvings",
        time.maximum_halvings,
        "How often a step that does not converge is halved before "
        "the run stops.",
        time.prm,
        Integer(0, 50));
      time.add_parameter(
        "Maximum travel",
        time.maximum_travel,
        "How much nearer parts of the material that meet, of one body "
        "or of several, and a particle and a wall may come in a "
        "step, in cells, with the velocities at its start. Parts "
        "that are farther apart may come to two cells from one "
        "another, or one from a wall. A longer step is shortened, "
        "and run.log says so; what flies or turns as a whole is not "
        "slowed. 0: no limit. Above 0.5 bodies can pass through one "
        "another without meeting.",
        time.prm,
        Double(0.));
      time.add_parameter(
        "Shorten last step",
        time.shorten_last_step,
        "Whether the last step is cut to end at <End time>. If not, "
        "the run ends with the first step that reaches it.");
    }
  } // namespace

  TimeParameters::TimeParameters(const std::string &path)
    : Section(path)
  {
    declare_integrator(*this);
    declare_steps(*this);
  }

  void
  TimeParameters::validate() const
  {
    const auto require_positive = [this](const std::string &name,
                                         const double       value,
                                         const std::string &unit) {
      AssertThrow(value > 0. && std::isfinite(value),
                  ExcParameter(path(),
                               name,
                               shortest(value),
                               "it is required and must be positive" + unit +
                                 "."));
    };
    require_positive("End time", end_time, " (s)");
    AssertThrow(raised_loads.empty() || is_static(),
                ExcParameter(path(),
                             "Raised loads",
                             join(raised_loads),
                             "only static steps raise loads. Remove it, or "
                             "set Integrator = static."));
    if (is_static())
      return;
    if (step_rule == "fixed")
      require_positive("Step size", step_size, " (s) with Step rule = fixed");
    else
      require_positive("Factor", factor, "");
  }

  double
  TimeParameters::latest_end() const
  {
    if (maximum_steps == 0)
      return end_time;
    return step_rule == "fixed" ? std::min(end_time, maximum_steps * step_size)
                                : 0.;
  }

  namespace
  {
    template <int dim>
    class ConstantStep : public StepRule<dim>
    {
    public:
      explicit ConstantStep(const double size)
        : size(size)
      {}

      double
      operator()(const Stencils<dim> &,
                 const PointArrays<dim> &,
                 const ActiveGrid<dim> &) const override
      {
        return size;
      }

      std::optional<double>
      constant() const override
      {
        return size;
      }

    private:
      const double size;
    };

    template <int dim>
    class NodalStep : public StepRule<dim>
    {
    public:
      NodalStep(const double        factor_times_h,
                const bool          is_normalised,
                std::vector<double> modulus_of_body,
                const FieldLayout  &layout)
        : factor_times_h(factor_times_h)
        , is_normalised(is_normalised)
        , modulus_of_body(std::move(modulus_of_body))
        , mass(layout["mass"])
        , reference_volume(layout["reference_volume"])
        , left_cauchy_green_less_unit(layout["left_cauchy_green_less_unit"])
      {}

      double
      operator()(const Stencils<dim>    &stencils,
                 const PointArrays<dim> &points,
                 const ActiveGrid<dim>  &active) const override
      {
        // nodal sums of mass, volume, modulus and weight
        std::array<std::vector<double>, 4> nodal;
        for (auto &sum : nodal)
          sum.resize(active.n_local_nodes());
        std::vector<double> volume(points.n_points());
        for (std::size_t p = 0; p < volume.size(); ++p)
          volume[p] = points.component(reference_volume)[p] *
                      std::sqrt(determinant_of_b(points, p));

        for (const auto &group : stencils.groups)
          for (unsigned int a = 0; a < group.n_nodes; ++a)
            {
              const double *S      = stencils.value(group, a);
              const double *m      = points.component(mass) + group.first_point;
              const double *V      = volume.data() + group.first_point;
              const auto    node   = active.nodes(group)[a];
              double        weight = 0.;
              for (unsigned int p = 0; p < group.n_points; ++p)
                {
                  nodal[0][node] += S[p] * m[p];
                  nodal[1][node] += S[p] * V[p];
                  weight += S[p];
                }
              nodal[2][node] += weight * modulus_of_body[group.body];
              nodal[3][node] += weight;
            }
        for (auto &sum : nodal)
          active.sum_over_ranks(sum);

        double smallest = std::numeric_limits<double>::max();
        for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
          if (nodal[0][node] > 0.)
            smallest =
              std::min(smallest,
                       nodal[0][node] / (nodal[1][node] * nodal[2][node]) *
                         (is_normalised ? nodal[3][node] : 1.));
        return factor_times_h *
               std::sqrt(
                 dealii::Utilities::MPI::min(smallest, active.communicator()));
      }

    private:
      double
      determinant_of_b(const PointArrays<dim> &points,
                       const std::size_t       p) const
      {
        return 1. +
               mandel::determinant_less_one<dim>(
                 points.template get<n_mandel<dim>>(left_cauchy_green_less_unit,
                                                    p));
      }

      const double              factor_times_h;
      const bool                is_normalised;
      const std::vector<double> modulus_of_body;
      const unsigned int mass, reference_volume, left_cauchy_green_less_unit;
    };
  } // namespace

  template <int dim>
  std::unique_ptr<StepRule<dim>>
  make_step_rule(const TimeParameters                     &parameters,
                 const BackgroundGrid<dim>                &grid,
                 const std::vector<const Material<dim> *> &material_of_body,
                 const FieldLayout                        &layout)
  {
    parameters.validate();
    if (parameters.is_static())
      return std::make_unique<ConstantStep<dim>>(parameters.end_time /
                                                 parameters.increments);
    if (parameters.step_rule == "fixed")
      return std::make_unique<ConstantStep<dim>>(parameters.step_size);

    const double        factor = parameters.factor * grid.shortest_side();
    std::vector<double> moduli;
    double              smallest_ratio = std::numeric_limits<double>::max();
    for (const auto *material : material_of_body)
      {
        moduli.push_back(material->p_wave_modulus());
        smallest_ratio =
          std::min(smallest_ratio,
                   material->density() / material->p_wave_modulus());
      }
    if (parameters.step_rule == "wave")
      return std::make_unique<ConstantStep<dim>>(factor *
                                                 std::sqrt(smallest_ratio));
    return std::make_unique<NodalStep<dim>>(
      factor, parameters.step_rule == "normalised", moduli, layout);
  }

  template std::unique_ptr<StepRule<2>>
  make_step_rule<2>(const TimeParameters &,
                    const BackgroundGrid<2> &,
                    const std::vector<const Material<2> *> &,
                    const FieldLayout &);
  template std::unique_ptr<StepRule<3>>
  make_step_rule<3>(const TimeParameters &,
                    const BackgroundGrid<3> &,
                    const std::vector<const Material<3> *> &,
                    const FieldLayout &);
} // namespace emmy
