#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/base/text.h>
#include <emmy/effects/tool_motion.h>

#include <cmath>

namespace emmy
{
  using dealii::Tensor;

  template <int dim>
  Tensor<1, dim>
  direction_of(const Section             &section,
               const std::string         &entry,
               const std::vector<double> &components)
  {
    Tensor<1, dim> result;
    for (unsigned int d = 0; d < std::min<std::size_t>(dim, components.size());
         ++d)
      result[d] = components[d];
    AssertThrow(components.size() == dim && result.norm() > 0.,
                ExcParameter(section.path(),
                             entry,
                             dealii::Patterns::Tools::to_string(components),
                             "it is required: " + std::to_string(dim) +
                               " components, not all zero, e.g. " +
                               (dim == 2 ? "0, -1." : "0, 0, -1.")));
    return result / result.norm();
  }

  template <int dim>
  void
  ToolMotionParameters<dim>::declare(Section &section)
  {
    using dealii::Patterns::Double;
    using dealii::Patterns::List;
    section.add_parameter("Reference point",
                          reference_point,
                          "Where the tool is at first: a point of a plane, the "
                          "middle of a ball, cylinder or box, the tip of a "
                          "cone. The tool turns about it, and its path and "
                          "moment are told there. Unit: m. Required.",
                          section.prm,
                          List(Double(), 0, dim));
    section.add_parameter("Displacement",
                          displacement,
                          "How far the reference point has moved, components "
                          "separated by , or ;, each a formula in the time t "
                          "(s): 0; -0.05*t. Unit: m. Empty: it rests.");
    section.add_parameter("Displacement table",
                          displacement_table,
                          "The same as times with components, separated by ;, "
                          "with straight lines between them and constant "
                          "beyond the ends: 0: 0, 0; 5: 0, -0.25. Units: s, "
                          "m. Empty: <Displacement> is used.");
    section.add_parameter("Velocity table",
                          velocity_table,
                          "The velocity of the reference point as times with "
                          "components, likewise: 0: 0, 0; 1: 0, -0.1. How far "
                          "it has moved is its integral, exactly. Units: s, "
                          "m/s. Empty: the displacement is given.");
    section.add_parameter("Rotation",
                          rotation,
                          "The angle that it has turned by, about the "
                          "reference point, a formula in t. Unit: rad.");
    if (dim == 3)
      section.add_parameter("Rotation axis",
                            axis,
                            "Direction about which it turns. Required if "
                            "<Rotation> is not 0.",
                            section.prm,
                            List(Double(), 0, dim));
  }

  namespace
  {
    template <int dim>
    std::vector<std::pair<double, Tensor<1, dim>>>
    read_table(const std::string &text,
               const std::string &entry,
               const std::string &section)
    {
      using namespace dealii::Utilities;
      const auto require = [&](const bool fact, const std::string &what) {
        AssertThrow(fact,
                    ExcParameter(section,
                                 entry,
                                 text,
                                 what +
                                   " Write <time: components> separated "
                                   "by ;, with times (s) that increase, "
                                   "e.g. " +
                                   (dim == 2 ? "0: 0, 0; 5: 0, -0.25."
                                             : "0: 0, 0, 0; 5: 0, 0, -0.25.")));
      };
      std::vector<std::pair<double, Tensor<1, dim>>> table;
      for (const std::string &item : split_string_list(text, ';'))
        {
          const std::string wrong = "<" + item + "> cannot be read.";
          const auto        pair  = split_string_list(item, ':');
          require(pair.size() == 2, wrong);
          const auto components = split_string_list(pair[1], ',');
          require(components.size() == dim, wrong);
          table.emplace_back();
          try
            {
              table.back().first = string_to_double(pair[0]);
              for (unsigned int d = 0; d < dim; ++d)
                table.back().second[d] = string_to_double(components[d]);
            }
          catch (const dealii::ExceptionBase &)
            {
              require(false, wrong);
            }
          require(std::isfinite(table.back().first) &&
                    std::isfinite(table.back().second.norm()),
                  wrong);
          require(table.size() == 1 ||
                    table.back().first > table[table.size() - 2].first,
                  "a tool cannot be in two places at a time: " +
                    shortest(table.back().first) + " s does not come later.");
        }
      return table;
    }
  } // namespace

  template <int dim>
  ToolMotion<dim>::ToolMotion(const ToolMotionParameters<dim> &parameters,
                              const Section                   &of_tool)
    : section(of_tool.path())
  {
    using dealii::Utilities::trim;
    const auto &point = parameters.reference_point;
    AssertThrow(point.size() == dim,
                ExcParameter(section,
                             "Reference point",
                             dealii::Patterns::Tools::to_string(point),
                             "it is required: " + std::to_string(dim) +
                               " coordinates in m, separated by ,."));
    for (unsigned int d = 0; d < dim; ++d)
      reference_point[d] = point[d];
    const bool has_table      = !trim(parameters.displacement_table).empty();
    const bool has_velocities = !trim(parameters.velocity_table).empty();
    if (has_table || has_velocities)
      {
        const char *entry = has_table ? "Displacement table" : "Velocity table";
        AssertThrow(trim(parameters.displacement).empty(),
                    ExcParameter(section,
                                 "Displacement",
                                 parameters.displacement,
                                 std::string("<") + entry +
                                   "> is given too. Remove one of them."));
        AssertThrow(!has_table || !has_velocities,
                    ExcParameter(section,
                                 "Velocity table",
                                 parameters.velocity_table,
                                 "<Displacement table> is given too. Remove "
                                 "one of them."));
        (has_table ? table : velocities) =
          read_table<dim>(has_table ? parameters.displacement_table
                                    : parameters.velocity_table,
                          entry,
                          section);
      }
    else if (!trim(parameters.displacement).empty())
      formulas.push_back(read_formulas<1>(
        parameters.displacement,
        dim,
        section,
        "Displacement",
        "Write " + std::to_string(dim) +
          " components separated by , or ;, each a formula in t, the time "
          "(s), in m, e.g. " +
          (dim == 2 ? "0; -0.05*t." : "0; 0; -0.05*t."),
        "t"));
    turns = trim(parameters.rotation) != "0";
    if (!turns)
      return;
    rotation = read_formulas<1>(parameters.rotation,
                                1,
                                section,
                                "Rotation",
                                "Write a formula in t, the time (s), e.g. "
                                "2*pi*t.",
                                "t");
    if (dim == 3)
      axis = direction_of<dim>(of_tool, "Rotation axis", parameters.axis);
  }

  template <int dim>
  double
  ToolMotion<dim>::checked(const double value,
                           const char  *entry,
                           const double time) const
  {
    AssertThrow(std::isfinite(value),
                ExcRun(section,
                       std::string(entry) + " is " + shortest(value) +
                         " at t = " + shortest(time) + " s",
                       "correct it: it must be finite at all times of the "
                       "run. What was written so far is kept."));
    return value;
  }

  template <int dim>
  Tensor<1, dim>
  ToolMotion<dim>::path(const double time) const
  {
    Tensor<1, dim> result;
    if (!formulas.empty())
      for (unsigned int d = 0; d < dim; ++d)
        result[d] = checked(formulas[0]->value(dealii::Point<1>(time), d),
                            "Displacement",
                            time);
    if (!velocities.empty())
      return travel(time) - travel(0.);
    if (table.empty())
      return result;
    const std::size_t row = row_at(table, time);
    if (time <= table[row].first || row + 1 == table.size())
      return table[row].second;
    const auto &[begin, from] = table[row];
    const auto &[end, to]     = table[row + 1];
    return from + (time - begin) / (end - begin) * (to - from);
  }

  template <int dim>
  std::size_t
  ToolMotion<dim>::row_at(const std::vector<Row> &table, const double time)
  {
    std::size_t row = 0;
    while (row + 1 < table.size() && table[row + 1].first <= time)
      ++row;
    return row;
  }

  template <int dim>
  Tensor<1, dim>
  ToolMotion<dim>::travel(const double time) const
  {
    Tensor<1, dim>    sum;
    const std::size_t row = row_at(velocities, time);
    for (std::size_t i = 0; i < row; ++i)
      sum += 0.5 * (velocities[i + 1].first - velocities[i].first) *
             (velocities[i].second + velocities[i + 1].second);
    const auto &[begin, from] = velocities[row];
    const double since        = time - begin;
    sum += since * from; // constant beyond the ends
    if (since <= 0. || row + 1 == velocities.size())
      return sum;
    const auto &[end, to] = velocities[row + 1];
    return sum + 0.5 * since * since / (end - begin) * (to - from);
  }

  template <int dim>
  dealii::Point<dim>
  ToolMotion<dim>::place(const double time) const
  {
    return reference_point + path(time);
  }

  template <int dim>
  double
  ToolMotion<dim>::angle(const double time) const
  {
    return turns ? checked(rotation->value(dealii::Point<1>(time)),
                           "Rotation",
                           time)
                 : 0.;
  }

  template <int dim>
  Tensor<2, dim>
  ToolMotion<dim>::about_axis(const double c, const double s) const
  {
    Tensor<2, dim> result = (1. - c) * outer_product(axis, axis);
    for (unsigned int d = 0; d < dim; ++d)
      result[d][d] += c;
    if (dim == 2)
      {
        result[0][1] -= s;
        result[1][0] += s;
        return result;
      }
    for (unsigned int d = 0; d < dim; ++d)
      {
        const unsigned int e = (d + 1) % dim, f = (d + 2) % dim;
        result[f][e] += s * axis[d];
        result[e][f] -= s * axis[d];
      }
    return result;
  }

  template <int dim>
  Tensor<2, dim>
  ToolMotion<dim>::turned(const double angle) const
  {
    return about_axis(std::cos(angle), std::sin(angle));
  }

  template <int dim>
  Tensor<2, dim>
  ToolMotion<dim>::directions(const double time) const
  {
    return turned(angle(time));
  }

  template <int dim>
  ToolStep<dim>
  ToolMotion<dim>::over(const double time, const double time_step) const
  {
    const double  end = time + time_step, from = angle(time), to = angle(end);
    const double  half = 0.5 * (to - from);
    ToolStep<dim> result;
    result.place        = place(time);
    result.displacement = path(end) - path(time);
    result.to_frame     = transpose(turned(from));
    result.to_space =
      about_axis(std::cos(half), 0.) * turned(0.5 * (from + to));
    result.spin = about_axis(0., 2. * std::tan(half)) -
                  outer_product(axis, axis); // of the axis nothing is left
    result.turn = 2. * std::abs(half);
    AssertThrow(result.turn <= dealii::numbers::PI_4,
                ExcRun(section,
                       "the tool turns by " + brief(result.turn) +
                         " rad in the step from t = " + brief(time) + " s",
                       "use smaller steps, or let it turn more slowly: a step "
                       "may turn it by at most pi/4."));
    return result;
  }

  template Tensor<1, 2>
  direction_of<2>(const Section &,
                  const std::string &,
                  const std::vector<double> &);
  template Tensor<1, 3>
  direction_of<3>(const Section &,
                  const std::string &,
                  const std::vector<double> &);
  template class ToolMotion<2>;
  template class ToolMotion<3>;
  template struct ToolMotionParameters<2>;
  template struct ToolMotionParameters<3>;
} // namespace emmy
