#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/output/particle_fields.h>
#include <emmy/run/scene_parameters.h>

#include <algorithm>
#include <sstream>

namespace emmy
{
  using dealii::Patterns::Bool;
  using dealii::Patterns::Double;
  using dealii::Patterns::Integer;
  using dealii::Patterns::Selection;

  GeneralParameters::GeneralParameters()
    : Section("")
  {
    add_parameter("Dimension",
                  dimension,
                  "2: plane strain, per metre of thickness. 3: space. "
                  "Required.",
                  prm,
                  Integer(0, 3));
    add_parameter("Title",
                  title,
                  "Stands over the pictures. Empty: the output directory.");
  }

  NameList::NameList(const std::string &path, const std::string &documentation)
    : Section(path)
  {
    add_parameter("Names", names, documentation);
  }

  namespace
  {
    std::vector<std::string>
    names_in(const ParameterFile &file,
             const std::string   &section,
             const std::string   &entry = "Names")
    {
      const auto names = dealii::Utilities::split_string_list(
        file.value(section + "/" + entry, ""));
      for (const std::string &name : names)
        AssertThrow(std::count(names.begin(), names.end(), name) == 1 &&
                      name.find('/') == std::string::npos,
                    ExcParameter(section,
                                 entry,
                                 join(names),
                                 "names must differ and hold no slash."));
      return names;
    }

    /** What was an effect is part of the method now. Throws ExcParameter. */
    void
    refuse_aggregation(const ParameterFile &file)
    {
      const auto names = names_in(file, "Effects");
      AssertThrow(std::count(names.begin(), names.end(), "aggregation") == 0 &&
                    !file.has_section("Effects/Aggregation"),
                  ExcParameter("Effects",
                               "Names",
                               join(names),
                               "aggregation is no effect any more, but what "
                               "starved nodes do by default. Write Method/"
                               "Starved nodes = follow, and Method/Starved "
                               "threshold for its Mass threshold; remove "
                               "<aggregation> here and the section "
                               "Effects/Aggregation."));
    }

    /** Throws ExcParameter for a choice that the file does not make. */
    void
    require_choice(const std::string              &value,
                   const std::string              &section,
                   const std::string              &entry,
                   const std::vector<std::string> &choices)
    {
      AssertThrow(!value.empty(),
                  ExcParameter(section,
                               entry,
                               "",
                               "it is required. Known are: " + join(choices) +
                                 "."));
    }
  } // namespace

  template <int dim>
  SceneParameters<dim>::Cleared::Cleared()
  {
    dealii::ParameterAcceptor::clear();
  }

  template <int dim>
  SceneParameters<dim>::SceneParameters(const ParameterFile &file)
    : material_names("Materials",
                     "Names of the materials. Each has a section of its name "
                     "with an entry <Model>: " +
                       join(material_library<dim>().names()) + ".")
    , body_names("Bodies",
                 "Names of the bodies. Each has a section of its name.")
    , moving_walls(dim)
    , effect_names("Effects",
                   "The effects of the scene beyond inertia and internal "
                   "force: " +
                     join(effect_library<dim>().names()) +
                     ". What is not named costs nothing.")
    , method(shape_function_library<dim>().names())
    , measurement_names("Measurements",
                        "Names of further columns of the ledger. Each has a "
                        "section of its name with an entry <Type>: " +
                          join(measurement_library<dim>().names()) +
                          ". Its columns are NAME_x and so on.")
  {
    // The file names things; each name brings a section, each model its
    // parameters. The handler prints in the order of declaration.
    for (const std::string &name : names_in(file, "Materials"))
      {
        const std::string section = "Materials/" + name;
        const std::string model   = file.value(section + "/Model", "");
        require_choice(model,
                       section,
                       "Model",
                       material_library<dim>().names());
        materials.push_back(
          material_library<dim>().find(model, section, "Model").make(section));
      }
    for (const std::string &name : names_in(file, "Bodies"))
      {
        const std::string section = "Bodies/" + name;
        const std::string shape   = file.value(section + "/Shape", "");
        require_choice(shape, section, "Shape", shape_library<dim>().names());
        bodies.push_back(std::make_unique<BodyParameters<dim>>(section, shape));
      }
    for (const std::string &name :
         names_in(file, "Boundary conditions", "Held parts"))
      held_parts.push_back(std::make_unique<HeldPartParameters<dim>>(
        "Boundary conditions/" + name));
    refuse_aggregation(file);
    for (const std::string &name : names_in(file, "Effects"))
      effect_library<dim>().find(name, "Effects", "Names");
    for (const std::string &name : names_in(file, "Measurements"))
      {
        const std::string section = "Measurements/" + name;
        const std::string type    = file.value(section + "/Type", "");
        require_choice(type,
                       section,
                       "Type",
                       measurement_library<dim>().names());
        measurements.push_back(
          measurement_library<dim>().find(type, section, "Type").make(section));
      }
    for (const auto &entry : effect_library<dim>().list())
      {
        effects[entry.name] = entry.make(effect_section(entry.name));
        effects[entry.name]->declare_named(file);
      }

    file.parse(dealii::ParameterAcceptor::prm);
    why_free = choose_method(file);
    dealii::ParameterAcceptor::parse_all_parameters();
    method.least_threshold = contact_sides.template least_threshold<dim>();
    choose_locking_treatment();
    for (const std::string &name : effect_names.names)
      method.least_threshold =
        std::max(method.least_threshold, effects.at(name)->least_threshold());
  }

  template <int dim>
  void
  SceneParameters<dim>::print(std::ostream &out) const
  {
    dealii::ParameterAcceptor::prm.print_parameters(
      out,
      dealii::ParameterHandler::PRM |
        dealii::ParameterHandler::KeepDeclarationOrder);
  }

  template <int dim>
  bool
  SceneParameters<dim>::wants_displacement() const
  {
    std::vector<std::string> names = output.particle_fields;
    names.push_back(output.picture_field);
    for (const auto &measurement : measurements)
      for (const std::string &name : measurement->fields())
        names.push_back(name);
    return emmy::wants_displacement(names);
  }

  unsigned int
  dimension_of(const ParameterFile &file)
  {
    const std::string dimension = file.value("Dimension", "");
    const std::string meant =
      dimension.empty() ? nearest_name("Dimension", file.entries_of("")) : "";
    AssertThrow(
      dimension == "2" || dimension == "3",
      ExcParameter("",
                   "Dimension",
                   dimension,
                   "it is required and must be 2 (plane strain) or "
                   "3." +
                     (meant.empty()
                        ? std::string()
                        : " Did you mean <Dimension>? The file has <" + meant +
                            ">.")));
    return dimension == "2" ? 2 : 3;
  }

  template class SceneParameters<2>;
  template class SceneParameters<3>;
} // namespace emmy
