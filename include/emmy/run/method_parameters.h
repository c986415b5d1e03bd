#ifndef emmy_run_method_parameters_h
#define emmy_run_method_parameters_h

#include <emmy/base/parameter_file.h>
#include <emmy/base/section.h>
#include <emmy/effects/starved_nodes.h>
#include <emmy/step/step_rule.h>
#include <emmy/transfer/particles_to_grid.h>

#include <memory>
#include <string>
#include <vector>

namespace emmy
{
  /** Section `Method`. */
  class MethodParameters : public Section
  {
  public:
    std::string shape_functions = "GIMP"; ///< `GIMP` or `linear`
    /** How boxes of GIMP follow: see transfer/domain_update. */
    std::string domain_update     = "stretch";
    std::string starved_nodes     = "follow"; ///< `follow` or `free`
    double      starved_threshold = 0.;       ///< 0: by the shape functions
    std::string mapping           = "FLIP";   ///< `FLIP`, `PIC` or a blend
    double      flip_fraction     = -1.;      ///< -1: not given
    double      lumping           = 0.;       ///< of the mass, 0 to 1
    /** See material/stress_rules. */
    std::string stress_rule = "conserving";
    /** `none`, `cell` or `automatic`. */
    std::string locking_treatment = "automatic";
    /** See effects/wall_mapping. */
    std::string wall_mapping       = "constrained";
    std::string geometry           = "middle"; ///< `start` or `middle`
    double      geometry_tolerance = 1e-8;     ///< cells
    /** What effects want at least where <Starved threshold> is not given. */
    double least_threshold = 0.;

    /** @param shape_function_names the values of <Shape functions> */
    explicit MethodParameters(
      const std::vector<std::string> &shape_function_names);

    /** Whether the grid is undeformed in the middle of a step. */
    bool
    is_at_middle(const TimeParameters &time) const;

    /**
     * What lets starved nodes follow, whether or not <Starved nodes> asks for
     * it. Throws ExcParameter.
     */
    template <int dim>
    std::unique_ptr<StarvedNodes<dim>>
    make_starved_nodes(const FieldLayout &layout) const;

    /** Check what belongs to the mapping. Throws ExcParameter. */
    PointMapping
    make_mapping() const;

  private:
    void
    declare_nodes(const std::vector<std::string> &shape_function_names);
    void
    declare_maps();
    void
    declare_stresses();
    void
    declare_geometry();
  };

  /**
   * Set <Starved nodes>, <Geometry> and <Stress rule> as steps and maps want
   * them, where a file does not name them. Before sections are parsed.
   * @return why starved nodes are free although the file does not say so; or
   *   empty
   */
  std::string
  choose_method(const ParameterFile &file);
} // namespace emmy

#endif
