#include <emmy/base/exceptions.h>
#include <emmy/base/parameter_file.h>
#include <emmy/base/text.h>
#include <emmy/effects/tool_parameters.h>

#include <algorithm>
#include <cctype>

namespace emmy
{
  using dealii::Patterns::Double;

  template <int dim>
  ToolParameters<dim>::ToolParameters(const std::string &section,
                                      const std::string &name,
                                      const std::string &shape_name)
    : Section(section)
    , name(name)
    , shape_name(shape_name)
  {
    this->add_parameter("Shape",
                        this->shape_name,
                        "What the tool looks like: " +
                          join(tool_shape_library<dim>().names()) +
                          (dim == 2 ? "" : " (cylinder and mesh in 3D only)") +
                          ". Its measures stand in a subsection of that name. "
                          "Required.");
    motion.declare(*this);
    push.declare(*this);
    this->add_parameter("Stiffness",
                        stiffness,
                        "Of the penalty, in P-wave moduli M of the body over "
                        "the spacing of its particles: a pressure sigma sinks "
                        "in by sigma/(Stiffness M) of the spacing. 0: 100 of "
                        "a plate that presses: a smooth plane whose "
                        "displacement is given and that does not hold; 10 of "
                        "others, which hold, or on which bodies bounce, roll "
                        "or slide. Dimensionless, not negative.",
                        this->prm,
                        Double());
    this->add_parameter("Friction coefficient",
                        friction,
                        "mu of Coulomb's law. 0: smooth. Dimensionless, not "
                        "negative.",
                        this->prm,
                        Double());
    this->add_parameter("Friction stiffness",
                        spring_stiffness,
                        "Of the springs that what sticks is held by, in "
                        "penalties. Near 1 Newton finds no end between stick "
                        "and slip. Dimensionless, positive.",
                        this->prm,
                        Double());
    this->add_parameter("Holds",
                        holds,
                        "Whether a plane keeps hold of what it touches at the "
                        "start: it then draws as it presses. What it touches "
                        "later it only pushes. Along itself it lets "
                        "everything slide.");
    shape = tool_shape_library<dim>()
              .find(shape_name, section, "Shape")
              .make(section + "/" + shape_name);
  }

  template <int dim>
  bool
  ToolParameters<dim>::is_turning() const
  {
    return dealii::Utilities::trim(motion.rotation) != "0";
  }

  template <int dim>
  std::unique_ptr<ToolShape<dim>>
  ToolParameters<dim>::make_shape() const
  {
    return shape->make();
  }

  template <int dim>
  ToolMotion<dim>
  ToolParameters<dim>::make_motion() const
  {
    return ToolMotion<dim>(motion, *this);
  }

  template <int dim>
  double
  ToolParameters<dim>::stiffness_meant() const
  {
    constexpr double of_plates = 100., of_others = 10.;
    const bool       moves = !motion.displacement.empty() ||
                       !motion.displacement_table.empty() ||
                       !motion.velocity_table.empty();
    const bool presses =
      shape_name == "plane" && friction == 0. && moves && !holds;
    return stiffness > 0. ? stiffness : presses ? of_plates : of_others;
  }

  template <int dim>
  std::vector<Field>
  ToolParameters<dim>::fields() const
  {
    std::vector<Field> result;
    if (friction > 0.)
      for (unsigned int corner = 0; corner < (1u << dim); ++corner)
        {
          std::string place; // lower or upper along each axis
          for (unsigned int d = 0; d < dim; ++d)
            place += corner >> d & 1 ? 'u' : 'l';
          result.push_back({"tool_" + name + "_spring_" + place,
                            Field::Kind::vector,
                            "m",
                            "stretch of what sticks a corner to the tool, in "
                            "the tool's frame; l, u: a lower, an upper corner "
                            "along x, y (and z)"});
        }
    if (holds)
      result.push_back({"tool_" + name + "_held",
                        Field::Kind::scalar,
                        "1",
                        "corners that the tool holds, as bits"});
    return result;
  }

  template <int dim>
  Tool<dim>
  ToolParameters<dim>::make(FieldLayout &layout) const
  {
    const auto require = [this](const bool         fact,
                                const std::string &entry,
                                const std::string &value,
                                const std::string &what) {
      AssertThrow(fact, ExcParameter(path(), entry, value, what));
    };
    require(stiffness >= 0.,
            "Stiffness",
            shortest(stiffness),
            "must be positive; 10 is good, 100 for plates. 0: one of these.");
    require(friction >= 0.,
            "Friction coefficient",
            shortest(friction),
            "must not be negative. 0: smooth.");
    require(spring_stiffness > 0.,
            "Friction stiffness",
            shortest(spring_stiffness),
            "must be positive; 0.1 is good.");
    require(!holds || shape_name == "plane",
            "Holds",
            "true",
            "only a plane can hold. Set Shape = plane, or Holds = false.");
    require(!holds || friction == 0.,
            "Friction coefficient",
            shortest(friction),
            "what a tool holds slides along it without friction. Remove it, "
            "or set Holds = false.");
    unsigned int first = Tool<dim>::none;
    for (const Field &field : fields())
      first = std::min(first, layout.add(field));
    return {name,
            make_shape(),
            make_motion(),
            stiffness_meant(),
            friction,
            spring_stiffness,
            friction > 0. ? first : Tool<dim>::none,
            holds ? first : Tool<dim>::none,
            push.make(*this)};
  }

  template <int dim>
  ToolsParameters<dim>::ToolsParameters(const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter("Names",
                        names,
                        "Names of the tools: letters, digits and _. Each has "
                        "a section of its name with an entry <Shape>: " +
                          join(tool_shape_library<dim>().names()) +
                          ". Its columns in the ledger are tool_NAME_work and "
                          "so on.");
  }

  template <int dim>
  void
  ToolsParameters<dim>::declare_named(const ParameterFile &file)
  {
    const auto listed = dealii::Utilities::split_string_list(
      file.value(this->path() + "/Names", ""));
    for (const std::string &name : listed)
      {
        const std::string section = this->path() + "/" + name;
        AssertThrow(std::count(listed.begin(), listed.end(), name) == 1 &&
                      std::all_of(name.begin(),
                                  name.end(),
                                  [](const char c) {
                                    return std::isalnum(
                                             static_cast<unsigned char>(c)) ||
                                           c == '_';
                                  }),
                    ExcParameter(this->path(),
                                 "Names",
                                 join(listed),
                                 "names must differ and consist of letters, "
                                 "digits and _."));
        const std::string shape = file.value(section + "/Shape", "");
        AssertThrow(!shape.empty(),
                    ExcParameter(section,
                                 "Shape",
                                 "",
                                 "it is required. Known are: " +
                                   join(tool_shape_library<dim>().names()) +
                                   "."));
        tools.push_back(
          std::make_unique<ToolParameters<dim>>(section, name, shape));
      }
  }

  template <int dim>
  std::string
  ToolsParameters<dim>::one_of_each() const
  {
    std::string              sections;
    std::vector<std::string> listed;
    for (const std::string &shape : tool_shape_library<dim>().names())
      {
        listed.push_back("the_" + shape);
        sections +=
          "subsection " + listed.back() + "\nset Shape = " + shape + "\nend\n";
      }
    return "set Names = " + join(listed) + "\n" + sections;
  }

  template <int dim>
  void
  ToolsParameters<dim>::add_to(Effects<dim> &effects, FieldLayout &layout) const
  {
    AssertThrow(!tools.empty(),
                ExcParameter(this->path(),
                             "Names",
                             "",
                             "at least one tool is required, with a section "
                             "of its name."));
    const typename Tools<dim>::Fields fields{
      layout["body"], layout.add(deformation_gradient_field<dim>())};
    std::vector<Tool<dim>> made;
    for (const auto &tool : tools)
      made.push_back(tool->make(layout));
    effects.terms.push_back(std::make_unique<Tools<dim>>(
      std::move(made), fields, corners_of_bodies(effects)));
  }

  template <int dim>
  std::vector<TimeHistory>
  ToolParameters<dim>::histories() const
  {
    std::vector<TimeHistory> result;
    const auto moved = std::make_shared<const ToolMotion<dim>>(motion, *this);
    for (unsigned int d = 0; d < dim; ++d)
      result.push_back(
        {"the displacement of tool " + name,
         [moved, d](const double t) { return moved->place(t)[d]; }});
    if (is_pushed())
      {
        const auto pushed =
          std::make_shared<const std::optional<ToolPush<dim>>>(
            push.make(*this));
        result.push_back(
          {"the force on tool " + name,
           [pushed](const double t) { return (*pushed)->force(t); }});
      }
    return result;
  }

  template <int dim>
  std::vector<TimeHistory>
  ToolsParameters<dim>::histories() const
  {
    std::vector<TimeHistory> result;
    for (const auto &tool : tools)
      for (TimeHistory &history : tool->histories())
        result.push_back(std::move(history));
    return result;
  }

  template <int dim>
  EffectCard
  ToolsParameters<dim>::card()
  {
    EffectCard card;
    card.enters         = "Newton: forces on corners of particles that touch "
                          "a tool";
    card.fields         = {deformation_gradient_field<dim>()};
    card.ledger_columns = {"contact_energy", "tool_NAME_work"};
    for (const std::string &column :
         Tools<dim>::columns_of("NAME", false, false))
      card.ledger_columns.push_back(column);
    return card;
  }

  template <int dim>
  EffectCard
  ToolsParameters<dim>::card_in_scene(const EffectCard &of_library) const
  {
    EffectCard card     = of_library;
    card.ledger_columns = {"contact_energy"};
    if (!std::all_of(tools.begin(), tools.end(), [](const auto &tool) {
          return tool->is_smooth();
        }))
      card.ledger_columns.insert(card.ledger_columns.end(),
                                 {"friction_energy", "friction_dissipation"});
    for (const auto &tool : tools)
      {
        card.ledger_columns.push_back("tool_" + tool->name + "_work");
        if (tool->is_pushed())
          card.ledger_columns.push_back("tool_" + tool->name +
                                        "_kinetic_energy");
        for (const std::string &column : Tools<dim>::columns_of(
               tool->name, tool->is_turning(), tool->is_pushed()))
          card.ledger_columns.push_back(column);
        for (const Field &field : tool->fields())
          card.fields.push_back(field);
      }
    return card;
  }

  template class ToolParameters<2>;
  template class ToolParameters<3>;
  template class ToolsParameters<2>;
  template class ToolsParameters<3>;
} // namespace emmy
