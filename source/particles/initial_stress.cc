#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/base/text.h>
#include <emmy/particles/initial_stress.h>

#include <algorithm>
#include <limits>
#include <map>

namespace emmy
{
  namespace
  {
    double
    number_of(const std::string &text)
    {
      return dealii::Utilities::string_to_double(text);
    }

    /** Whether an entry that may be empty is one number otherwise. */
    bool
    is_number_or_empty(const std::string &text)
    {
      return text.find_first_of(",;") == std::string::npos;
    }
  } // namespace

  double
  LevelGround::vertical_stress(const double height) const
  {
    const double below_water = std::max(0., water_level - height);
    const double above =
      std::max(0., surface_level - std::max(height, water_level));
    // where water stands above the ground, all that is below it is ground
    const double in_water = std::min(below_water, surface_level - height);
    return -(surcharge + unit_weight * above +
             buoyant_unit_weight * std::max(0., in_water));
  }

  template <int dim>
  InitialStress<dim>::InitialStress(const LevelGround &ground)
    : ground(ground)
  {}

  template <int dim>
  InitialStress<dim>::InitialStress(
    std::unique_ptr<dealii::FunctionParser<dim>> components)
    : components(std::move(components))
  {}

  template <int dim>
  MandelVector<dim>
  InitialStress<dim>::at(const dealii::Point<dim> &place) const
  {
    MandelVector<dim> stress;
    if (!components)
      {
        const double vertical = ground.vertical_stress(place[dim - 1]);
        stress          = ground.lateral_ratio * vertical * mandel::unit<dim>();
        stress[dim - 1] = vertical;
        return stress;
      }
    // of a symmetric tensor, whatever the order of components inside
    dealii::Tensor<2, dim> block;
    const auto             component = [&](const unsigned int i) {
      return components->value(place, i);
    };
    for (unsigned int d = 0; d < dim; ++d)
      block[d][d] = component(d);
    block[0][1] = block[1][0] = component(3);
    if constexpr (dim == 3)
      {
        block[0][2] = block[2][0] = component(4);
        block[1][2] = block[2][1] = component(5);
      }
    stress = mandel::symmetric_part<dim>(block);
    if (dim == 2)
      stress[n_mandel<dim> - 1] = component(2);
    return stress;
  }

  void
  InitialStressParameters::add_to(Section &section, const unsigned int dim)
  {
    auto      &prm = dealii::ParameterAcceptor::prm;
    const auto any = dealii::Patterns::Double();
    // or nothing
    const auto number = dealii::Patterns::List(any, 0, 1);
    section.add_parameter(
      "Initial stress",
      kind,
      "Cauchy stress at the start, which must be within what the material "
      "bears. none: there is none. level ground: that of level ground, by "
      "depth along the last axis. formulas: <Stress>.",
      prm,
      dealii::Patterns::Selection("none|level ground|formulas"));
    section.add_parameter("Ground level",
                          surface_level,
                          "Of level ground: the height of its surface. "
                          "Unit: m. Required there.",
                          prm,
                          number);
    section.add_parameter("Unit weight",
                          unit_weight,
                          "Of level ground: its weight per volume. Unit: "
                          "N/m^3. Required there, not negative.",
                          prm,
                          any);
    section.add_parameter("Water level",
                          water_level,
                          "Of level ground: the height below which "
                          "<Buoyant unit weight> is its weight. Unit: m. "
                          "Empty: there is no water.",
                          prm,
                          number);
    section.add_parameter("Buoyant unit weight",
                          buoyant_unit_weight,
                          "Of level ground below the water: its weight less "
                          "that of the water that it displaces. Unit: N/m^3.",
                          prm,
                          any);
    section.add_parameter("Surcharge",
                          surcharge,
                          "Of level ground: a pressure on its surface, not "
                          "negative. Unit: Pa.",
                          prm,
                          any);
    section.add_parameter("K0",
                          lateral_ratio,
                          "Of level ground: the horizontal over the vertical "
                          "stress. Dimensionless. Required there, not "
                          "negative.",
                          prm,
                          number);
    section.add_parameter("Stress",
                          components,
                          "Formulas in x, y (and z), in m, of the components "
                          "xx; yy; zz; xy" +
                            std::string(dim == 2 ? "" : "; xz; yz") +
                            ", positive in tension. Unit: Pa. Required with "
                            "Initial stress = formulas.");
  }

  template <int dim>
  std::unique_ptr<InitialStress<dim>>
  InitialStressParameters::make(const std::string &section) const
  {
    const auto require = [&section](const bool         condition,
                                    const std::string &name,
                                    const std::string &value,
                                    const std::string &advice) {
      AssertThrow(condition, ExcParameter(section, name, value, advice));
    };
    for (const auto &[name, value] :
         std::map<std::string, std::string>{{"Ground level", surface_level},
                                            {"Water level", water_level},
                                            {"K0", lateral_ratio}})
      require(is_number_or_empty(value),
              name,
              value,
              "it must be one number, without commas, or nothing.");
    if (kind == "none")
      return nullptr;
    if (kind == "formulas")
      return std::make_unique<InitialStress<dim>>(read_formulas<dim>(
        components,
        dim == 2 ? 4 : 6,
        section,
        "Stress",
        "Write the components xx; yy; zz; xy" +
          std::string(dim == 2 ? "" : "; xz; yz") +
          " in Pa, each a formula in " +
          dealii::FunctionParser<dim>::default_variable_names() + "."));
    require(!surface_level.empty(),
            "Ground level",
            "",
            "level ground needs the height of its surface (m).");
    require(surcharge >= 0.,
            "Surcharge",
            shortest(surcharge),
            "a pressure (Pa) must not be negative.");
    require(unit_weight >= 0. && (unit_weight > 0. || surcharge > 0.),
            "Unit weight",
            shortest(unit_weight),
            "level ground needs its weight per volume (N/m^3), density times "
            "acceleration.");
    require(water_level.empty() || buoyant_unit_weight > 0.,
            "Buoyant unit weight",
            shortest(buoyant_unit_weight),
            "ground in water needs its weight per volume there (N/m^3), e.g. "
            "10e3.");
    require(!lateral_ratio.empty() && number_of(lateral_ratio) >= 0.,
            "K0",
            lateral_ratio,
            "required, and must not be negative. Without lateral strain it is "
            "nu/(1 - nu); in sand about 1 - sin(phi).");
    return std::make_unique<InitialStress<dim>>(
      LevelGround{number_of(surface_level),
                  unit_weight,
                  water_level.empty() ? std::numeric_limits<double>::lowest()
                                      : number_of(water_level),
                  buoyant_unit_weight,
                  surcharge,
                  number_of(lateral_ratio)});
  }

  template class InitialStress<2>;
  template class InitialStress<3>;
  template std::unique_ptr<InitialStress<2>>
  InitialStressParameters::make<2>(const std::string &) const;
  template std::unique_ptr<InitialStress<3>>
  InitialStressParameters::make<3>(const std::string &) const;
} // namespace emmy
