#include <deal.II/base/quadrature_lib.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/base/text.h>
#include <emmy/grid/held_part.h>

#include <cmath>

namespace emmy
{
  template <int dim>
  dealii::Tensor<1, dim>
  HeldPart<dim>::velocity_at(const double time) const
  {
    dealii::Tensor<1, dim> result;
    for (unsigned int c = 0; c < dim; ++c)
      if (velocity[c])
        result[c] = velocity[c]->value(dealii::Point<1>(time));
    AssertThrow(std::isfinite(result.norm()),
                ExcRun("Boundary conditions/" + name,
                       "its <Velocity> is not finite at t = " + brief(time) +
                         " s",
                       "correct the formula, or end the run earlier "
                       "(Time/End time)."));
    return result;
  }

  template <int dim>
  dealii::Tensor<1, dim>
  HeldPart<dim>::displacement_over(const double time,
                                   const double time_step) const
  {
    const dealii::QGauss<1> gauss(4);
    dealii::Tensor<1, dim>  result;
    for (unsigned int q = 0; q < gauss.size(); ++q)
      result += gauss.weight(q) * time_step *
                velocity_at(time + gauss.point(q)[0] * time_step);
    return result;
  }

  template <int dim>
  HeldPartParameters<dim>::HeldPartParameters(const std::string &section)
    : Section(section)
    , name(section.substr(section.rfind('/') + 1))
  {
    this->add_parameter("Region",
                        region,
                        "A formula in x, y (and z), in m: the nodes of the "
                        "grid where it is positive are held, as long as a "
                        "body reaches them. Required.");
    this->add_parameter("Velocity",
                        velocity,
                        std::to_string(dim) +
                          " components separated by , or ;, each a formula in "
                          "t (s), 0 for one that rests, or the word free. The "
                          "region stays where it is: a body should move "
                          "through it by less than a cell. What a side holds "
                          "belongs to the side. Unit: m/s. Required.");
  }

  template <int dim>
  HeldPart<dim>
  HeldPartParameters<dim>::make() const
  {
    HeldPart<dim> part;
    part.name   = name;
    part.region = read_formulas<dim>(
      region,
      1,
      this->path(),
      "Region",
      "Write a formula in " +
        dealii::FunctionParser<dim>::default_variable_names() +
        " that is positive at the nodes to be held, e.g. if(x < 1.01 & y > "
        "2.99, 1, -1).");
    const std::string remedy =
      "Write " + std::to_string(dim) +
      " components separated by , or ;, each a formula in t (m/s) or the word "
      "free, e.g. 0; " +
      (dim == 2 ? "-0.01*t." : "0; -0.01*t.");
    const auto words =
      dealii::Utilities::split_string_list(separated_by(';', velocity), ';');
    AssertThrow(words.size() == dim,
                ExcParameter(this->path(), "Velocity", velocity, remedy));
    part.velocity.resize(dim);
    for (unsigned int c = 0; c < dim; ++c)
      if (words[c] != "free")
        {
          part.components.set(c);
          part.velocity[c] = read_formulas<1>(
            words[c], 1, this->path(), "Velocity", remedy, "t");
        }
    AssertThrow(part.components.any(),
                ExcParameter(this->path(),
                             "Velocity",
                             velocity,
                             "it holds nothing. " + remedy));
    return part;
  }

  template struct HeldPart<2>;
  template struct HeldPart<3>;
  template class HeldPartParameters<2>;
  template class HeldPartParameters<3>;
} // namespace emmy
