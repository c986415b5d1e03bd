#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/material/stress_rules.h>
#include <emmy/run/method_parameters.h>
#include <emmy/transfer/domain_update.h>

#include <algorithm>

namespace emmy
{
  using dealii::Patterns::Double;
  using dealii::Patterns::Selection;

  MethodParameters::MethodParameters(
    const std::vector<std::string> &shape_function_names)
    : Section("Method")
  {
    // the best of those that there are
    if (std::count(shape_function_names.begin(),
                   shape_function_names.end(),
                   shape_functions) == 0 &&
        !shape_function_names.empty())
      shape_functions = shape_function_names.front();
    declare_nodes(shape_function_names);
    declare_maps();
    declare_stresses();
    declare_geometry();
  }

  void
  MethodParameters::declare_nodes(
    const std::vector<std::string> &shape_function_names)
  {
    add_parameter("Shape functions",
                  shape_functions,
                  "linear: bi- or trilinear functions of the cell (standard "
                  "MPM). GIMP: particles are boxes, which reach the nodes of "
                  "all cells that they overlap.",
                  prm,
                  Selection(join(shape_function_names, "|")));
    add_parameter("Domain update",
                  domain_update,
                  "How the boxes of GIMP follow the deformation gradient F. "
                  "none: they keep their size. detF: as its determinant. "
                  "diagF: as its diagonal, which vanishes when a body turns. "
                  "stretch: as the diagonal of sqrt(F^T F). corners: as the "
                  "extent of the moved corners, with the volume of F.",
                  prm,
                  Selection(domain_update_names()));
    add_parameter("Starved nodes",
                  starved_nodes,
                  "Nodes that have next to no mass. follow: they follow the "
                  "nearest cell whose nodes all have more, without loss of "
                  "energy or momentum. Where particles are as large as cells, "
                  "with 1 point per direction, nodes move as those of cells "
                  "twice as large. free: they move on their own. follow needs "
                  "implicit steps and Wall mapping = constrained; a file that "
                  "has neither this entry nor those gets free.",
                  prm,
                  Selection("follow|free"));
    add_parameter(
      "Starved threshold",
      starved_threshold,
      "A node is starved with less than this part of the mass that "
      "a full body would give it. Below 2^-dim corners of a block "
      "of full cells are fed. 0: 0.02 with GIMP, in space 0.05; "
      "with linear functions 0.15, in space 0.12; with rigid tools at "
      "least 0.2, in space 0.12. Dimensionless, below 1.",
      prm,
      Double(0.));
  }

  void
  MethodParameters::declare_maps()
  {
    add_parameter("Mapping",
                  mapping,
                  "FLIP: particles take the change of the grid's velocity. "
                  "PIC: they take the velocity, and lose what the grid does "
                  "not see of theirs. blend: <FLIP fraction> of FLIP, the "
                  "rest of PIC.",
                  prm,
                  Selection("FLIP|PIC|blend"));
    add_parameter("FLIP fraction",
                  flip_fraction,
                  "Share of FLIP in Mapping = blend. Dimensionless, between 0 "
                  "and 1. -1: not given.",
                  prm,
                  Double());
    add_parameter("Lumping",
                  lumping,
                  "epsilon of eq. 18. 0: consistent mass matrix, which "
                  "conserves energy. 1: lumped. Between: (1 - epsilon) "
                  "consistent + epsilon lumped. Dimensionless.",
                  prm,
                  Double());
  }

  void
  MethodParameters::declare_stresses()
  {
    add_parameter("Stress rule",
                  stress_rule,
                  "The stress that acts during a step. conserving: balances "
                  "energy. mid-point: that of the mid-point's deformation. "
                  "trapezoidal: the mean of both ends. end-point: that of the "
                  "end. All keep momenta; the ledger's stress_rule_loss is "
                  "the energy that the last three lose or make; where few "
                  "particles reach a node, mid-point can make very much.",
                  prm,
                  Selection(stress_rule_names()));
    add_parameter("Locking treatment",
                  locking_treatment,
                  "What keeps bodies from locking, that is from being far too "
                  "stiff, where their volume can hardly change: with a "
                  "Poisson's ratio near 0.5, and in plastic flow. none: "
                  "nothing. cell: in a step the volume of all particles of a "
                  "cell changes alike, without loss of energy or momentum. "
                  "automatic: cell for the bodies that flow plastically or "
                  "have a Poisson's ratio above 0.4 (fluids, above "
                  "0.4999995, do not ask), unless explicit steps, another "
                  "<Stress rule> or Domain update = corners have no place "
                  "for it; none for the others.",
                  prm,
                  Selection("automatic|none|cell"));
  }

  void
  MethodParameters::declare_geometry()
  {
    add_parameter("Wall mapping",
                  wall_mapping,
                  "constrained: fixed nodes have the velocity of the wall in "
                  "the point-to-grid map too. unconstrained: the map knows no "
                  "walls, and fixed nodes bounce. inelastic: as constrained, "
                  "but particles lose what the wall takes from the grid's "
                  "velocity.",
                  prm,
                  Selection("constrained|unconstrained|inelastic"));
    add_parameter("Geometry",
                  geometry,
                  "Where a step takes its shape functions, mass and loads. "
                  "start: at the particles' places at its start (Pretti et "
                  "al. 2023); under compression motion at the size of a cell "
                  "then grows, with all balances exact. middle: at their "
                  "places in its middle, which Newton finds; a file without "
                  "this entry gets start with explicit steps and with linear "
                  "functions, or static ones.",
                  prm,
                  Selection("middle|start"));
    add_parameter("Geometry tolerance",
                  geometry_tolerance,
                  "How well the places of the middle must hold before a step "
                  "ends. Unit: cells. Positive.",
                  prm,
                  Double());
  }

  bool
  MethodParameters::is_at_middle(const TimeParameters &time) const
  {
    AssertThrow(geometry_tolerance > 0.,
                ExcParameter(path(),
                             "Geometry tolerance",
                             shortest(geometry_tolerance),
                             "must be positive (cells); 1e-8 is good."));
    AssertThrow(geometry != "middle" || !time.is_explicit(),
                ExcParameter(path(),
                             "Geometry",
                             geometry,
                             "explicit steps take force and strain at the "
                             "same time and need no middle. Remove it, or set "
                             "it to start."));
    AssertThrow(!time.is_static() ||
                  (geometry == "start" && stress_rule == "end-point"),
                ExcParameter(path(),
                             geometry != "start" ? "Geometry" : "Stress rule",
                             geometry != "start" ? geometry : stress_rule,
                             "static steps balance the stress at the end of an "
                             "increment in the places at its start. Remove the "
                             "entry: a file with static steps needs neither "
                             "<Geometry> nor <Stress rule>."));
    return geometry == "middle";
  }

  template <int dim>
  std::unique_ptr<StarvedNodes<dim>>
  MethodParameters::make_starved_nodes(const FieldLayout &layout) const
  {
    AssertThrow(starved_threshold < 1.,
                ExcParameter(path(),
                             "Starved threshold",
                             shortest(starved_threshold),
                             "must lie between 0 and 1, 1 excluded. 0.02 to "
                             "0.05 is good with GIMP, 0.1 to 0.2 with linear "
                             "functions; 0 chooses."));
    // linear functions need more; below 2^-dim a block has all its corners
    const bool   is_linear = shape_functions == "linear";
    const double usual =
      dim == 2 ? (is_linear ? 0.15 : 0.02) : (is_linear ? 0.12 : 0.05);
    return std::make_unique<StarvedNodes<dim>>(
      Aggregation<dim>(starved_threshold > 0.
                         ? starved_threshold
                         : std::max(usual, least_threshold),
                       layout["mass"],
                       layout["reference_volume"]));
  }

  PointMapping
  MethodParameters::make_mapping() const
  {
    const auto require = [this](const bool         condition,
                                const std::string &name,
                                const std::string &value,
                                const std::string &advice) {
      AssertThrow(condition, ExcParameter(path(), name, value, advice));
    };
    require(lumping >= 0. && lumping <= 1.,
            "Lumping",
            shortest(lumping),
            "must lie between 0 (consistent) and 1 (lumped).");
    if (mapping == "blend")
      require(flip_fraction >= 0. && flip_fraction <= 1.,
              "FLIP fraction",
              shortest(flip_fraction),
              "Mapping = blend requires it, between 0 (PIC) and 1 (FLIP).");
    else
      require(flip_fraction == -1.,
              "FLIP fraction",
              shortest(flip_fraction),
              "Mapping = " + mapping +
                " contradicts it. Remove it, or set Mapping = blend.");
    if (mapping == "PIC")
      require(wall_mapping == "constrained",
              "Wall mapping",
              wall_mapping,
              std::string("Mapping = PIC contradicts it: ") +
                (wall_mapping == "inelastic"
                   ? "with PIC particles keep nothing that a wall could take."
                   : "particles would take the bounce of the fixed nodes.") +
                " Use constrained, or Mapping = FLIP or blend.");

    PointMapping result;
    result.lumping = lumping;
    result.flip_fraction =
      mapping == "FLIP" ? 1. : (mapping == "PIC" ? 0. : flip_fraction);
    return result;
  }

  std::string
  choose_method(const ParameterFile &file)
  {
    auto      &prm = dealii::ParameterAcceptor::prm;
    const auto get = [&prm](const char *section, const char *entry) {
      prm.enter_subsection(section);
      const std::string value = prm.get(entry);
      prm.leave_subsection();
      return value;
    };
    // the parameters that a run writes say what it does
    const auto choose = [&](const char *entry, const char *value) {
      if (!file.value(std::string("Method/") + entry, "").empty())
        return false;
      prm.enter_subsection("Method");
      prm.set(entry, value);
      prm.leave_subsection();
      return true;
    };
    const bool        is_explicit = get("Time", "Integrator") == "explicit";
    const bool        is_static   = get("Time", "Integrator") == "static";
    const std::string walls       = get("Method", "Wall mapping");
    std::string       why_free;
    if (is_explicit && choose("Starved nodes", "free"))
      why_free = "explicit steps have no equation that they could follow in";
    else if (walls != "constrained" && choose("Starved nodes", "free"))
      why_free = "the map of Wall mapping = " + walls +
                 " would need followers of its own";
    if (is_explicit || is_static ||
        get("Method", "Shape functions") == "linear")
      choose("Geometry", "start");
    if (is_static)
      choose("Stress rule", "end-point");
    return why_free;
  }

  template std::unique_ptr<StarvedNodes<2>>
  MethodParameters::make_starved_nodes<2>(const FieldLayout &) const;
  template std::unique_ptr<StarvedNodes<3>>
  MethodParameters::make_starved_nodes<3>(const FieldLayout &) const;
} // namespace emmy
