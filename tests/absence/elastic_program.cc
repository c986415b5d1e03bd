// emmy with nothing in its libraries but what an elastic body in free flight
// needs. The linker takes these lists instead of those of emmy; nothing else
// names the other effects, materials and shape functions, so their code is not
// in the program.
#include <emmy/effects/effect.h>
#include <emmy/material/hencky.h>
#include <emmy/particles/stencils.h>
#include <emmy/study/program.h>

namespace emmy
{
  template <int dim>
  Library<EffectParameters<dim>> &
  effect_library()
  {
    static Library<EffectParameters<dim>> library;
    return library;
  }

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
      return materials;
    }();
    return library;
  }

  template <int dim>
  Library<ShapeFunctions<dim>, FieldLayout &> &
  shape_function_library()
  {
    static Library<ShapeFunctions<dim>, FieldLayout &> library = [] {
      Library<ShapeFunctions<dim>, FieldLayout &> functions;
      functions.add({"linear",
                     "bi- or trilinear functions of the cell (standard MPM)",
                     [](FieldLayout &layout) {
                       return std::make_unique<LinearShapeFunctions<dim>>(
                         layout["body"]);
                     },
                     LinearShapeFunctions<dim>::card()});
      return functions;
    }();
    return library;
  }

  template Library<EffectParameters<2>> &
  effect_library<2>();
  template Library<EffectParameters<3>> &
  effect_library<3>();
  template Library<MaterialParameters<2>> &
  material_library<2>();
  template Library<MaterialParameters<3>> &
  material_library<3>();
  template Library<ShapeFunctions<2>, FieldLayout &> &
  shape_function_library<2>();
  template Library<ShapeFunctions<3>, FieldLayout &> &
  shape_function_library<3>();
} // namespace emmy

int
main(int argc, char *argv[])
{
  return emmy::run_program(argc, argv);
}
