#include <emmy/material/drucker_prager.h>
#include <emmy/material/neo_hooke.h>
#include <emmy/material/von_mises.h>

namespace emmy
{
  template <int dim>
  Library<MaterialParameters<dim>> &
  material_library()
  {
    static Library<MaterialParameters<dim>> library = [] {
      Library<MaterialParameters<dim>> materials;
      materials.add({"Hencky",
                     "isotropic elasticity, quadratic in logarithmic strain",
                     [](const std::string &section) {
                       return std::make_unique<HenckyParameters<dim>>(section);
                     }});
      materials.add({"von Mises",
                     "Hencky elasticity with plastic flow and hardening",
                     [](const std::string &section) {
                       return std::make_unique<VonMisesParameters<dim>>(
                         section);
                     },
                     VonMisesParameters<dim>::card()});
      materials.add({"Drucker-Prager",
                     "Hencky elasticity with friction, cohesion, dilation and "
                     "a tension cut-off: soils",
                     [](const std::string &section) {
                       return std::make_unique<DruckerPragerParameters<dim>>(
                         section);
                     },
                     DruckerPragerParameters<dim>::card()});
      materials.add({"neo-Hooke",
                     "compressible neo-Hooke elasticity",
                     [](const std::string &section) {
                       return std::make_unique<NeoHookeParameters<dim>>(
                         section);
                     }});
      return materials;
    }();
    return library;
  }

  template Library<MaterialParameters<2>> &
  material_library<2>();
  template Library<MaterialParameters<3>> &
  material_library<3>();
} // namespace emmy
