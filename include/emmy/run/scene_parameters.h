#ifndef emmy_run_scene_parameters_h
#define emmy_run_scene_parameters_h

#include <emmy/base/parameter_file.h>
#include <emmy/effects/effect.h>
#include <emmy/effects/moving_walls.h>
#include <emmy/effects/reactions.h>
#include <emmy/effects/tool_sides.h>
#include <emmy/grid/boundary_conditions.h>
#include <emmy/material/material.h>
#include <emmy/output/measurement.h>
#include <emmy/particles/body.h>
#include <emmy/run/checkpoint_parameters.h>
#include <emmy/run/method_parameters.h>
#include <emmy/run/output_parameters.h>
#include <emmy/run/rank_balance.h>
#include <emmy/run/start.h>
#include <emmy/solve/linear_solver.h>
#include <emmy/step/small_cuts.h>
#include <emmy/step/step_rule.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /** The entries before the first section. */
  class GeneralParameters : public Section
  {
  public:
    unsigned int dimension = 0; ///< 2 or 3
    std::string  title;         ///< for pictures and pages

    GeneralParameters();
  };

  /** A section that lists names, each with a section of its own. */
  class NameList : public Section
  {
  public:
    std::vector<std::string> names; ///< in their order

    /** Declares the entry `Names` of a section. */
    NameList(const std::string &path, const std::string &documentation);
  };

  /**
   * All parameters of a scene: one struct per section, declared for the names
   * that the file lists, then filled from the file. Only one may exist at a
   * time, because deal.II's ParameterAcceptor keeps a global list.
   */
  template <int dim>
  class SceneParameters
  {
  public:
    /** Throws ExcParameter or ExcRun for anything unknown or misspelt. */
    explicit SceneParameters(const ParameterFile &file);

    /** Print all parameters with their values and documentation. */
    void
    print(std::ostream &out) const;

    /** Whether anything that is written needs to know displacements. */
    bool
    wants_displacement() const;

  private:
    /** Empties ParameterAcceptor's list of what an earlier scene left. */
    struct Cleared
    {
      Cleared();
    } cleared;

  public:
    /** Dimension and title. */
    GeneralParameters   general;
    GridParameters<dim> grid; ///< the grid
    /** Of materials. */
    NameList material_names;
    /** In the order of their names. */
    std::vector<std::unique_ptr<MaterialParameters<dim>>> materials;
    /** Of bodies. */
    NameList body_names;
    /** In the order of their names. */
    std::vector<std::unique_ptr<BodyParameters<dim>>> bodies;
    /** Fixed and roller sides. */
    BoundaryParameters boundary_conditions;
    /** Sides with contact. */
    ContactSideParameters contact_sides;
    /** In the order of their names. */
    std::vector<std::unique_ptr<HeldPartParameters<dim>>> held_parts;
    /** Whether they are asked for. */
    ReactionParameters reactions;
    /** Velocities of sides. */
    MovingWallParameters moving_walls;
    /** Those that act. */
    NameList effect_names;
    /** By effect name: of all effects there are, named or not. */
    std::map<std::string, std::unique_ptr<EffectParameters<dim>>> effects;
    /** Of the step. */
    MethodParameters method;
    /** Steps. */
    TimeParameters time;
    /** Newton, and linear systems. */
    SolverParameters solver;
    /** Of small cuts. */
    DiagnosisParameters diagnosis;
    /** Of measurements. */
    NameList measurement_names;
    /** In the order of their names. */
    std::vector<std::unique_ptr<MeasurementParameters<dim>>> measurements;
    /** Files and pictures. */
    OutputParameters output;
    /** When they are written. */
    CheckpointParameters checkpoint;
    /** When cells are cut anew. */
    RankParameters ranks;
    /** Another run's results. */
    StartParameters start;
    /** See choose_method(). */
    std::string why_free;
    /** The materials that Locking treatment is for; none: there is none. */
    std::vector<std::string> locking_materials;

    /** Whether it is for each of these bodies. */
    std::vector<bool>
    are_treated(const std::vector<Body<dim>> &of_scene) const;
    /** What the head of a run says of it, behind other methods. */
    std::string
    locking_summary() const;

  private:
    /** For which materials Locking treatment = automatic is. */
    void
    choose_locking_treatment();
  };

  /** The dimension a file asks for: 2 or 3. Throws ExcParameter otherwise. */
  unsigned int
  dimension_of(const ParameterFile &file);

  /**
   * A file in three dimensions that names each material, shape and effect
   * there is, so that its parameters are the reference of all parameters.
   */
  ParameterFile
  reference_file();
} // namespace emmy

#endif
