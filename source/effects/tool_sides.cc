#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/tool_parameters.h>
#include <emmy/effects/tool_sides.h>

#include <algorithm>

namespace emmy
{
  using dealii::Tensor;

  namespace
  {
    /** "x-min" -> "x_min", as in the names of columns. */
    std::string
    tool_of(std::string side)
    {
      std::replace(side.begin(), side.end(), '-', '_');
      return side;
    }
  } // namespace

  ContactSideParameters::ContactSideParameters(const std::string &section)
    : Section(section)
  {
    add_parameter("Contact",
                  sides,
                  "Sides of the grid that only push, and let go of what "
                  "leaves them; without friction. A list of sides, as for "
                  "<Fixed>. For friction, or a side that moves, use a tool.",
                  prm,
                  dealii::Patterns::List(dealii::Patterns::Anything(), 0));
    add_parameter("Contact stiffness",
                  stiffness,
                  "Of these sides, as <Stiffness> of a tool. Dimensionless, "
                  "positive.",
                  prm,
                  dealii::Patterns::Double());
  }

  template <int dim>
  double
  ContactSideParameters::least_threshold() const
  {
    return are_present() ? ToolsParameters<dim>::threshold : 0.;
  }

  template <int dim>
  void
  ContactSideParameters::add_to(
    const BackgroundGrid<dim>     &grid,
    const BoundaryConditions<dim> &boundary_conditions,
    Effects<dim>                  &effects,
    FieldLayout                   &layout) const
  {
    layout.set_effect(contact_sides_effect);
    AssertThrow(stiffness > 0.,
                ExcParameter(path(),
                             "Contact stiffness",
                             shortest(stiffness),
                             "must be positive; 10 is good."));
    const dealii::Point<dim> lower = grid.lower_corner(),
                             upper = grid.upper_corner();
    std::vector<Tool<dim>> tools;
    for (const std::string &name : sides)
      {
        const unsigned int side = side_number(name, dim, path(), "Contact");
        AssertThrow(std::count(sides.begin(), sides.end(), name) == 1 &&
                      boundary_conditions.fixed_components_of(side).none(),
                    ExcParameter(path(),
                                 "Contact",
                                 join(sides),
                                 "<" + name +
                                   "> stands there twice, or in <Fixed> or "
                                   "<Roller> too. Remove one of them."));
        const bool         is_upper = side % 2;
        Tensor<1, dim>     normal;
        dealii::Point<dim> place = lower + 0.5 * (upper - lower);
        normal[side / 2]         = is_upper ? -1. : 1.;
        place[side / 2]          = (is_upper ? upper : lower)[side / 2];
        ToolMotionParameters<dim> rests;
        for (unsigned int d = 0; d < dim; ++d)
          rests.reference_point.push_back(place[d]);
        Tool<dim> tool{tool_of(name),
                       std::make_unique<Plane<dim>>(normal),
                       ToolMotion<dim>(rests, *this),
                       stiffness,
                       0.,
                       0.};
        tools.push_back(std::move(tool));
      }
    const typename Tools<dim>::Fields fields{
      layout["body"], layout.add(deformation_gradient_field<dim>())};
    effects.terms.push_back(std::make_unique<Tools<dim>>(
      std::move(tools), fields, corners_of_bodies(effects)));
    effects.name_new(contact_sides_effect);
  }

  template <int dim>
  EffectCard
  contact_sides_card(const ContactSideParameters &parameters)
  {
    EffectCard card     = ToolsParameters<dim>::card();
    card.name           = contact_sides_effect;
    card.setting        = "Boundary conditions/Contact";
    card.is_present     = parameters.are_present();
    card.ledger_columns = {"contact_energy"};
    for (const std::string &side : parameters.sides)
      {
        card.ledger_columns.push_back("tool_" + tool_of(side) + "_work");
        for (const std::string &column :
             Tools<dim>::columns_of(tool_of(side), false, false))
          card.ledger_columns.push_back(column);
      }
    return card;
  }

#define INSTANTIATE(dim)                                                             \
  template double     ContactSideParameters::least_threshold<dim>() const;           \
  template void       ContactSideParameters::add_to(const BackgroundGrid<dim> &,     \
                                              const BoundaryConditions<dim> &, \
                                              Effects<dim> &,                  \
                                              FieldLayout &) const;            \
  template EffectCard contact_sides_card<dim>(const ContactSideParameters &);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
