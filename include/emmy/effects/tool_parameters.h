#ifndef emmy_effects_tool_parameters_h
#define emmy_effects_tool_parameters_h

#include <emmy/effects/advice.h>
#include <emmy/effects/time_history.h>
#include <emmy/effects/tools.h>

namespace emmy
{
  /** Section of a tool, e.g. `Effects/Tools/plate`. */
  template <int dim>
  class ToolParameters : public Section
  {
  public:
    /** @param shape name of a shape of tools, read beforehand. */
    ToolParameters(const std::string &section,
                   const std::string &name,
                   const std::string &shape);

    /** Check and build; throws ExcParameter. Asks for the fields it needs. */
    Tool<dim>
    make(FieldLayout &layout) const;

    /** The fields that it asks for: where corners stick, what is held. */
    std::vector<Field>
    fields() const;

    /** Whether its normal never jumps. */
    bool
    is_smooth() const
    {
      return friction == 0.;
    }
    /** Whether it turns at any time. */
    bool
    is_turning() const;
    /** Whether a force moves it. */
    bool
    is_pushed() const
    {
      return push.is_given();
    }
    /** Displacements along the axes, and the force that pushes it. */
    std::vector<TimeHistory>
    histories() const;

    /** Whether it keeps hold of what it touches at the start. */
    bool
    is_holding() const
    {
      return holds;
    }
    /** What it looks like; throws ExcParameter. */
    std::unique_ptr<ToolShape<dim>>
    make_shape() const;
    /** How it is told to move; throws ExcParameter. */
    ToolMotion<dim>
    make_motion() const;

    const std::string name; ///< as in `Names`

  private:
    /**
     * The stiffness that is meant: 100 of a smooth plane whose displacement is
     * given, a plate that presses; 10 of others, unless it is given.
     */
    double
    stiffness_meant() const;

    std::string               shape_name;
    ToolMotionParameters<dim> motion;
    ToolPushParameters<dim>   push;
    double stiffness = 0., friction = 0., spring_stiffness = 0.1;
    bool   holds = false;
    std::unique_ptr<ToolShapeParameters<dim>> shape;
  };

  /** Section `Effects/Tools`. */
  template <int dim>
  class ToolsParameters : public EffectParameters<dim>,
                          public Adviser<dim>,
                          public GivenOverTime
  {
  public:
    /** Declares the tools that `Names` lists. */
    explicit ToolsParameters(const std::string &section);

    void
    declare_named(const ParameterFile &file) override;
    std::string
    one_of_each() const override;
    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    /**
     * A tool acts on the last layer of particles. Where that fills little of
     * its cells, nodes that only it reaches let it tear off or fold: they must
     * follow earlier.
     */
    static constexpr double threshold = dim == 2 ? 0.2 : 0.12;
    double
    least_threshold() const override
    {
      return threshold;
    }

    /** Of any tool; that of a scene has its names. */
    static EffectCard
    card();
    EffectCard
    card_in_scene(const EffectCard &of_library) const override;
    std::vector<TimeHistory>
    histories() const override;

    /**
     * Which tools touch no particle in the whole run, and which are outside of
     * the grid from some time on, as far as that can be known beforehand. Of a
     * tool that a force pushes nothing is said, and of one that rests nothing
     * if something else may move bodies. Cost: see ToolPath.
     */
    std::vector<std::string>
    advice(const BeforeTheRun<dim> &run) const override;

  private:
    std::vector<std::string>                          names;
    std::vector<std::unique_ptr<ToolParameters<dim>>> tools;
  };
} // namespace emmy

#endif
