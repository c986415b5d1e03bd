#include <emmy/base/dealii_version.h>
#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/grid/boundary_conditions.h>
#include <emmy/particles/basic_shapes.h>
#include <emmy/particles/body.h>
#include <emmy/particles/particle_layout.h>
#include <emmy/particles/particle_table.h>
#include <emmy/particles/shape_formula.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace emmy
{
  using dealii::Point;

  template <int dim>
  BodyParameters<dim>::BodyParameters(const std::string &section,
                                      const std::string &shape)
    : Section(section)
    , shape_name(shape)
  {
    this->add_parameter(
      "Shape",
      shape_name,
      "What the body looks like: " + join(shape_library<dim>().names()) +
        " (cylinder and mesh in 3D only; in plane strain a disc is a "
        "ball). Its measures stand in a subsection of that name. Or a "
        "formula, without a subsection: difference(box(0, 0; 4, 1), "
        "ball(2, 0.5; 0.2)). Functions are box, ball, half_space, "
        "expression, polygon (2D), cylinder, cone and mesh (3D); union, "
        "intersection, difference; shift, turn, scale. Required.");
    this->add_parameter("Material",
                        material,
                        "One of Materials/Names. Required.");
    this->add_parameter(
      "Points per direction",
      points_per_direction,
      "Each cell is divided into this number of boxes in "
      "each direction; a box whose centre is in the shape "
      "becomes a particle, with the mass of its box. A box that does not "
      "fit is divided itself, see <Particle layout>. Required.",
      this->prm,
      dealii::Patterns::Integer(0));
    this->add_parameter(
      "Particle layout",
      particle_layout,
      "What is divided into the boxes of particles. body: a box is divided "
      "itself, into boxes whose size is as near as it can be to that of the "
      "cells' boxes, so that it stands where it is written; for other shapes "
      "the cells. cells: always the cells, whose boxes can stick out of the "
      "body or leave it uncovered by half their size.",
      this->prm,
      dealii::Patterns::Selection("body|cells"));
    this->add_parameter(
      "Initial velocity",
      initial_velocity,
      "Components separated by , or ;, each a formula in x, y "
      "(and z). Unit: m/s. Empty: at rest.");
    this->add_parameter(
      "Angular velocity",
      angular_velocity,
      std::string("Adds a rotation to the initial velocity: ") +
        (dim == 2 ? "about z, turning x to y." : "a vector along the axis.") +
        " Unit: rad/s. Empty: none.",
      this->prm,
      dealii::Patterns::List(dealii::Patterns::Double(), 0, dim == 2 ? 1 : 3));
    this->add_parameter("Center of rotation",
                        center_of_rotation,
                        "A point of the axis of <Angular velocity>, which "
                        "requires it. Unit: m.",
                        this->prm,
                        dealii::Patterns::List(dealii::Patterns::Double(),
                                               0,
                                               dim));
    this->add_parameter(
      "Cut by",
      cut_by,
      "Sides of the grid beyond which the shape may reach; "
      "what lies outside is left out, as where a side is a "
      "plane of symmetry; that side should then be a <Roller>, or "
      "the cut is a free face. A list of x-min, x-max, y-min, "
      "y-max, z-min, z-max.",
      this->prm,
      dealii::Patterns::List(dealii::Patterns::Anything(), 0));
    initial_stress.add_to(*this, dim);
    if (!shape.empty() && !is_shape_formula(shape))
      shape_parameters = shape_library<dim>()
                           .find(shape, section, "Shape")
                           .make(section + "/" + shape);
  }

  template <int dim>
  std::unique_ptr<Shape<dim>>
  BodyParameters<dim>::make_shape() const
  {
    return is_shape_formula(shape_name)
             ? read_shape<dim>(shape_name, this->path())
             : shape_parameters->make();
  }

  template <int dim>
  void
  BodyParameters<dim>::validate() const
  {
    AssertThrow(shape_parameters != nullptr || is_shape_formula(shape_name),
                ExcParameter(this->path(),
                             "Shape",
                             "",
                             "it is required. Known shapes are: " +
                               join(shape_library<dim>().names()) + "."));
    const auto require_all = [this](const std::string         &name,
                                    const std::vector<double> &numbers,
                                    const unsigned int         n) {
      AssertThrow(angular_velocity.empty() ? numbers.empty()
                                           : numbers.size() == n,
                  ExcParameter(this->path(),
                               name,
                               dealii::Patterns::Tools::to_string(numbers),
                               "a rotation needs <Angular velocity>, " +
                                 std::to_string(dim == 2 ? 1 : 3) +
                                 " numbers in rad/s, and <Center of "
                                 "rotation>, " +
                                 std::to_string(dim) + " in m."));
    };
    require_all("Angular velocity", angular_velocity, dim == 2 ? 1 : 3);
    require_all("Center of rotation", center_of_rotation, dim);
    AssertThrow(points_per_direction > 0,
                ExcParameter(this->path(),
                             "Points per direction",
                             std::to_string(points_per_direction),
                             "it is required and must be at least 1."));
  }

  template <int dim>
  Body<dim>
  make_body(const std::string         &name,
            const BodyParameters<dim> &parameters,
            const unsigned int         material,
            const double               density)
  {
    parameters.validate();
    Body<dim> body;
    body.name                 = name;
    body.material             = material;
    body.density              = density;
    body.points_per_direction = parameters.points_per_direction;
    body.divides_box          = parameters.particle_layout == "body";
    body.shape                = parameters.make_shape();
    for (const std::string &side : parameters.cut_by)
      body.cut_by.set(side_number(side, dim, parameters.path(), "Cut by"));

    std::string text = parameters.initial_velocity;
    if (dealii::Utilities::trim(text).empty())
      for (unsigned int d = 0; d < dim; ++d)
        text += d == 0 ? "0" : ";0";
    body.initial_velocity = read_formulas<dim>(
      text,
      dim,
      parameters.path(),
      "Initial velocity",
      "Write " + std::to_string(dim) +
        " components separated by , or ;, each a formula in " +
        dealii::FunctionParser<dim>::default_variable_names() + ", e.g. " +
        (dim == 2 ? "0.75; 0" : "0.75; 0; 0") + ".");
    const auto &omega = parameters.angular_velocity;
    for (unsigned int i = 0; i < omega.size(); ++i)
      body.angular_velocity[dim == 2 ? 2 : i] = omega[i];
    for (unsigned int d = 0; d < parameters.center_of_rotation.size(); ++d)
      body.center_of_rotation[d] = parameters.center_of_rotation[d];
    body.initial_stress =
      parameters.initial_stress.template make<dim>(parameters.path());
    return body;
  }

  template <int dim>
  dealii::Tensor<1, dim>
  Body<dim>::velocity_at(const Point<dim> &position) const
  {
    dealii::Tensor<1, 3>   arm;
    dealii::Tensor<1, dim> velocity;
    for (unsigned int d = 0; d < dim; ++d)
      arm[d] = position[d] - center_of_rotation[d];
    const auto rotation = dealii::cross_product_3d(angular_velocity, arm);
    for (unsigned int d = 0; d < dim; ++d)
      velocity[d] = initial_velocity->value(position, d) + rotation[d];
    return velocity;
  }

#define INSTANTIATE(dim)                                                     \
  template class BodyParameters<dim>;                                        \
  template dealii::Tensor<1, dim> Body<dim>::velocity_at(const Point<dim> &) \
    const;                                                                   \
  template Body<dim> make_body<dim>(const std::string &,                     \
                                    const BodyParameters<dim> &,             \
                                    const unsigned int,                      \
                                    const double);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
