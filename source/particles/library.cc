#include <emmy/particles/gimp.h>

namespace emmy
{
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
      functions.add({"GIMP",
                     "particles are boxes, which reach the nodes of all cells "
                     "that they overlap",
                     [](FieldLayout &layout) {
                       return std::make_unique<GimpShapeFunctions<dim>>(layout);
                     },
                     GimpShapeFunctions<dim>::card()});
      return functions;
    }();
    return library;
  }

  template Library<ShapeFunctions<2>, FieldLayout &> &
  shape_function_library<2>();
  template Library<ShapeFunctions<3>, FieldLayout &> &
  shape_function_library<3>();
} // namespace emmy
