// How a run of the stability suite goes: what its ledger says of it.

#include <chrono>
#include <map>

#include "../scene.h"
#include "suite.h"

namespace emmy
{
  namespace stability
  {
    namespace
    {
      /** What momenta are compared with: m v, and m v times a length. */
      template <int dim>
      struct MomentumScale
      {
        double linear, angular; ///< kg m/s, kg m^2/s

        MomentumScale(const Scene<dim> &scene, const Ledger &ledger)
        {
          const double             mass = test::total_mass(scene);
          dealii::BoundingBox<dim> box(
            std::make_pair(scene.particles.begin()->get_location(),
                           scene.particles.begin()->get_location()));
          for (const auto &particle : scene.particles)
            box.merge_with(dealii::BoundingBox<dim>(std::make_pair(
              particle.get_location(), particle.get_location())));
          const auto corners = box.get_boundary_points();
          linear             = std::sqrt(2. * ledger["kinetic_energy"] * mass);
          angular            = linear * corners.first.distance(corners.second);
        }
      };

      /** One step after the other, until the end or an error. */
      template <int dim>
      void
      advance_to_end(Scene<dim>           &scene,
                     const TimeParameters &limits,
                     Ledger               &ledger,
                     Result               &result)
      {
        try
          {
            while (ledger["time"] < limits.end_time * (1. - 1e-12) &&
                   (limits.maximum_steps == 0 ||
                    result.steps < limits.maximum_steps))
              {
                const StepReport report = scene.advance();
                ledger.add(report);
                ++result.steps;
                for (const std::string &note : report.notes)
                  result.halvings +=
                    note.find("halved to") != std::string::npos;
                result.damped += report.is_damped;
              }
            result.has_ended = true;
          }
        catch (const ExcRun &error)
          {
            result.problem = message_of(error);
          }
      }

      /** All values of a column; zeros if there is no such column. */
      std::vector<double>
      column(const Ledger &ledger, const std::string &name)
      {
        const auto &names    = ledger.columns();
        const auto  position = std::find(names.begin(), names.end(), name);
        std::vector<double> result;
        for (const auto &row : ledger.rows())
          result.push_back(
            position == names.end() ? 0. : row[position - names.begin()]);
        return result;
      }

      std::vector<double>
      sum_of_columns(const Ledger                   &ledger,
                     const std::vector<std::string> &names)
      {
        std::vector<double> sum(ledger.rows().size());
        for (const std::string &name : names)
          {
            const auto values = column(ledger, name);
            for (unsigned int i = 0; i < sum.size(); ++i)
              sum[i] += values[i];
          }
        return sum;
      }

      std::vector<double>
      changes(std::vector<double> values)
      {
        const double first = values[0];
        for (double &value : values)
          value -= first;
        return values;
      }

      /** Numbers that the ledger holds. NaN stays NaN. */
      template <int dim>
      void
      evaluate(const Ledger             &ledger,
               const MomentumScale<dim> &scale,
               Result                   &result)
      {
        const auto kept = sum_of_columns(
          ledger, {"kinetic_energy", "strain_energy", "hardening_energy"});
        const auto lost =
          sum_of_columns(ledger, {"ghost_mass_loss", "ghost_stiffness_loss"});
        const auto brought =
          sum_of_columns(ledger,
                         {"load_work", "reaction_work", "residual_work"});
        const auto dissipated = column(ledger, "plastic_dissipation");
        auto       drift      = changes(kept);
        for (unsigned int i = 0; i < drift.size(); ++i)
          drift[i] += lost[i] + dissipated[i] - brought[i];

        result.energy       = test::largest(kept);
        const double energy = result.energy > 0. ? result.energy : 1.;
        result.times        = column(ledger, "time");
        result.followers    = column(ledger, "followers");
        for (const std::string &name : ledger.columns())
          result.ledger[name] = column(ledger, name);
        result.kinetic        = column(ledger, "kinetic_energy");
        result.strain         = column(ledger, "strain_energy");
        result.balance_errors = column(ledger, "balance_error");
        for (auto *const values :
             {&result.kinetic, &result.strain, &result.balance_errors})
          for (double &value : *values)
            value /= energy;
        result.final_energy  = kept.back();
        result.lost          = lost.back() / energy;
        result.drift         = test::largest(drift) / energy;
        result.balance_error = test::largest(result.balance_errors);
        result.residual_work =
          test::largest(column(ledger, "residual_work")) / energy;
        result.most_iterations =
          test::largest(column(ledger, "newton_iterations"));
        result.mass_condition = test::largest(column(ledger, "mass_condition"));
        result.jacobian_condition =
          test::largest(column(ledger, "jacobian_condition"));
        for (const std::string &name : ledger.columns())
          if (name.find("linear_momentum_") == 0)
            result.linear_momentum = test::largest(
              {result.linear_momentum,
               test::largest(changes(column(ledger, name))) / scale.linear});
          else if (name.find("angular_momentum_") == 0)
            result.angular_momentum = test::largest(
              {result.angular_momentum,
               test::largest(changes(column(ledger, name))) / scale.angular});
      }

      template <int dim>
      std::vector<double>
      positions(const Scene<dim> &scene)
      {
        std::map<dealii::types::particle_index, dealii::Point<dim>> by_number;
        for (const auto &particle : scene.particles)
          by_number[particle.get_id()] = particle.get_location();
        std::vector<double> result;
        for (const auto &entry : by_number)
          for (unsigned int d = 0; d < dim; ++d)
            result.push_back(entry.second[d]);
        return result;
      }

      template <int dim>
      Result
      run_file(const ParameterFile &file, const Run<dim> &run)
      {
        const SceneParameters<dim> parameters(file);
        Scene<dim>                 scene(parameters, MPI_COMM_SELF);
        if (run.prepare)
          run.prepare(scene);
        Ledger                   ledger(scene.initial_report(), dim);
        const MomentumScale<dim> scale(scene, ledger);

        Result     result;
        const auto start = std::chrono::steady_clock::now();
        advance_to_end(scene, parameters.time, ledger, result);
        result.seconds = std::chrono::duration<double>(
                           std::chrono::steady_clock::now() - start)
                           .count();
        evaluate(ledger, scale, result);
        result.positions = positions(scene);
        return result;
      }
    } // namespace

    template <int dim>
    Result
    run_scene(const std::string &folder, const Run<dim> &run)
    {
      ParameterFile file(folder + "/prm/" + run.file);
      for (const std::string &setting : run.settings)
        file.set(setting);
      Result result = run_file(file, run);
      if (run.with_conditions)
        {
          // apart, as it takes its time
          file.set("Diagnosis/Small cuts=true");
          const Result diagnosed    = run_file(file, run);
          result.mass_condition     = diagnosed.mass_condition;
          result.jacobian_condition = diagnosed.jacobian_condition;
        }
      return result;
    }

    template Result
    run_scene<2>(const std::string &, const Run<2> &);
    template Result
    run_scene<3>(const std::string &, const Run<3> &);
  } // namespace stability
} // namespace emmy
