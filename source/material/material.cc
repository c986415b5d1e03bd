#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/material/graded_material.h>

namespace emmy
{
  template <int dim>
  MaterialParameters<dim>::MaterialParameters(const std::string &section)
    : Section(section)
  {
    const std::string place =
      "A formula in x, y (and z), in m, of where a particle starts, positive: ";
    this->add_parameter("Model",
                        model,
                        "The material's law: " +
                          join(material_library<dim>().names()) +
                          ". Required.");
    this->add_parameter("Stiffness factor",
                        stiffness_factor,
                        place + "what elastic constants and the hardening "
                                "modulus are multiplied by, e.g. 1 + 0.1*(20 "
                                "- y) for ground at y = 20. Dimensionless. "
                                "Empty: the same everywhere.");
    this->add_parameter("Strength factor",
                        strength_factor,
                        place + "what the yield stress, or cohesion and "
                                "tension cut-off, are multiplied by. "
                                "Dimensionless. Empty: the same everywhere.");
  }

  template <int dim>
  std::unique_ptr<Material<dim>>
  MaterialParameters<dim>::make_graded() const
  {
    auto       base = make();
    const auto read = [this](const std::string &text,
                             const std::string &entry) {
      return dealii::Utilities::trim(text).empty()
               ? nullptr
               : read_formulas<dim>(
                   text,
                   1,
                   this->path(),
                   entry,
                   "Write one formula in " +
                     dealii::FunctionParser<dim>::default_variable_names() +
                     ", e.g. 1 + 0.1*(20 - y).");
    };
    auto stiffness = read(stiffness_factor, "Stiffness factor");
    auto strength  = read(strength_factor, "Strength factor");
    if (!stiffness && !strength)
      return base;
    AssertThrow(!strength || base->has_strength(),
                ExcParameter(this->path(),
                             "Strength factor",
                             strength_factor,
                             "the model <" + model +
                               "> has no strength. Remove the entry, or take "
                               "a model that flows."));
    return std::make_unique<GradedMaterial<dim>>(std::move(base),
                                                 std::move(stiffness),
                                                 std::move(strength));
  }

  template class MaterialParameters<2>;
  template class MaterialParameters<3>;
} // namespace emmy
