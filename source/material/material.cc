#include <emmy/material/material.h>

namespace emmy
{
  template <int dim>
  MaterialParameters<dim>::MaterialParameters(const std::string &section)
    : Section(section)
  {
    this->add_parameter("Model",
                        model,
                        "The material's law: " +
                          join(material_library<dim>().names()) +
                          ". Required.");
  }

  template class MaterialParameters<2>;
  template class MaterialParameters<3>;
} // namespace emmy
