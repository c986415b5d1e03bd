#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/base/parameter_file.h>
#include <emmy/base/text.h>
#include <emmy/effects/surface_loads.h>

#include <algorithm>

namespace emmy
{
  template <int dim>
  SurfaceLoadParameters<dim>::SurfaceLoadParameters(const std::string &section,
                                                    const std::string &name)
    : Section(section)
    , name(name)
  {
    using namespace dealii::Patterns;
    this->add_parameter("Side",
                        side,
                        "Where the loaded faces look at the start: x-min, "
                        "x-max, y-min, y-max, z-min, z-max. In each row of "
                        "particles along it the last one in <Region> is "
                        "loaded. all: all around the particles in <Region>, "
                        "for a pressure.");
    this->add_parameter("Region",
                        region,
                        "A formula in x, y (and z), in m, positive at the "
                        "start where the particles are that may be loaded. "
                        "Empty: everywhere.");
    this->add_parameter("Traction",
                        traction,
                        "Force on each area of the undeformed surface, its "
                        "components separated by , or ;. It keeps its "
                        "direction. The amplitude multiplies it. Unit: Pa. "
                        "Either this or <Pressure>.",
                        this->prm,
                        List(Double(), 0, dim, ";"));
    this->add_parameter("Pressure",
                        pressure,
                        "Force on each area of the deformed surface, against "
                        "its normal, whichever way it turns. The amplitude "
                        "multiplies it. Unit: Pa. Either this or <Traction>.");
    amplitude.declare(*this);
  }

  template <int dim>
  bool
  SurfaceLoadParameters<dim>::is_pressure() const
  {
    return traction.empty();
  }

  template <int dim>
  Field
  SurfaceLoadParameters<dim>::field() const
  {
    return {"surface_load_" + name,
            Field::Kind::scalar,
            "1",
            "faces of the particle's box that the load acts on, as bits: 1 "
            "that of x-min, 2 of x-max, 4 of y-min, and so on"};
  }

  template <int dim>
  void
  SurfaceLoadParameters<dim>::add_to(Effects<dim> &effects,
                                     FieldLayout  &layout) const
  {
    const auto require = [this](const bool         fact,
                                const std::string &entry,
                                const std::string &value,
                                const std::string &what) {
      AssertThrow(fact, ExcParameter(path(), entry, value, what));
    };
    require(traction.empty() || traction.size() == dim,
            "Traction",
            dealii::Patterns::Tools::to_string(traction),
            "it has " + std::to_string(dim) +
              " components in Pa, separated by , or ;, e.g. " +
              (dim == 2 ? "0; -1e4." : "0; 0; -1e4."));
    require((pressure != 0.) == traction.empty(),
            "Pressure",
            shortest(pressure),
            traction.empty() ? "the load needs this or <Traction>."
                             : "<Traction> is given too. Remove one of them.");
    require(side != "all" || traction.empty(),
            "Side",
            side,
            "a traction needs a side, e.g. y-max. Only a pressure can act all "
            "around.");
    auto choice     = std::make_shared<SurfaceLoadChoice<dim>>();
    choice->section = path();
    choice->name    = name;
    if (side != "all")
      choice->side = side_number(side, dim, path(), "Side");
    if (!dealii::Utilities::trim(region).empty())
      choice->region = read_formulas<dim>(
        region,
        1,
        path(),
        "Region",
        "Write a formula in " +
          dealii::FunctionParser<dim>::default_variable_names() +
          " that is positive at the surface that holds the "
          "load.");
    choice->amplitude = std::make_shared<Amplitude>(amplitude, path());
    choice->follows   = is_pressure();
    choice->pressure  = pressure;
    for (unsigned int d = 0; d < traction.size(); ++d)
      choice->traction[d] = traction[d];
    const LoadedFaces<dim> faces({layout["body"],
                                  layout.add(deformation_gradient_field<dim>()),
                                  layout.add(field())},
                                 choice,
                                 effects.half_length_of_body);
    if (is_pressure())
      effects.terms.push_back(std::make_unique<Pressure<dim>>(faces));
    else
      effects.terms.push_back(std::make_unique<Traction<dim>>(faces));
  }

  template <int dim>
  SurfaceLoadsParameters<dim>::SurfaceLoadsParameters(
    const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter("Names",
                        names,
                        "Names of the loads: letters, digits and _. Each has "
                        "a section of its name.");
  }

  template <int dim>
  void
  SurfaceLoadsParameters<dim>::declare_named(const ParameterFile &file)
  {
    const auto listed = dealii::Utilities::split_string_list(
      file.value(this->path() + "/Names", ""));
    for (const std::string &name : listed)
      {
        AssertThrow(std::count(listed.begin(), listed.end(), name) == 1 &&
                      std::all_of(name.begin(),
                                  name.end(),
                                  [](const unsigned char c) {
                                    return std::isalnum(c) || c == '_';
                                  }),
                    ExcParameter(this->path(),
                                 "Names",
                                 join(listed),
                                 "names must differ and consist of letters, "
                                 "digits and _."));
        loads.push_back(std::make_unique<SurfaceLoadParameters<dim>>(
          this->path() + "/" + name, name));
      }
  }

  template <int dim>
  std::string
  SurfaceLoadsParameters<dim>::one_of_each() const
  {
    return "set Names = a_load\n";
  }

  template <int dim>
  void
  SurfaceLoadsParameters<dim>::add_to(Effects<dim> &effects,
                                      FieldLayout  &layout) const
  {
    AssertThrow(!loads.empty(),
                ExcParameter(this->path(),
                             "Names",
                             "",
                             "at least one load is required, with a section "
                             "of its name."));
    for (const auto &load : loads)
      load->add_to(effects, layout);
  }

  template <int dim>
  std::vector<TimeHistory>
  SurfaceLoadsParameters<dim>::histories() const
  {
    std::vector<TimeHistory> result;
    for (const auto &load : loads)
      result.push_back(load->history());
    return result;
  }

  template <int dim>
  EffectCard
  SurfaceLoadsParameters<dim>::card()
  {
    EffectCard card;
    card.enters         = "loads of the step; pressures: Newton";
    card.fields         = {deformation_gradient_field<dim>()};
    card.ledger_columns = {"load_work", "pressure_NAME_work"};
    return card;
  }

  template <int dim>
  EffectCard
  SurfaceLoadsParameters<dim>::card_in_scene(const EffectCard &of_library) const
  {
    EffectCard card = of_library;
    card.ledger_columns.clear();
    for (const auto &load : loads)
      {
        card.fields.push_back(load->field());
        if (load->is_pressure())
          card.ledger_columns.push_back("pressure_" + load->name + "_work");
        else if (std::count(card.ledger_columns.begin(),
                            card.ledger_columns.end(),
                            "load_work") == 0)
          card.ledger_columns.push_back("load_work");
      }
    return card;
  }

  template class SurfaceLoadParameters<2>;
  template class SurfaceLoadParameters<3>;
  template class SurfaceLoadsParameters<2>;
  template class SurfaceLoadsParameters<3>;
} // namespace emmy
