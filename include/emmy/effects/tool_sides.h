#ifndef emmy_effects_tool_sides_h
#define emmy_effects_tool_sides_h

#include <emmy/effects/tools.h>

namespace emmy
{
  /** The name that sides which only push have among the effects. */
  constexpr const char *contact_sides_effect = "contact sides";

  /**
   * The entries of section `Boundary conditions` on sides that only push: each
   * is a smooth plane tool at rest, that lets go of what leaves it. Its name
   * is that of the side with _ for -.
   */
  class ContactSideParameters : public Section
  {
  public:
    /** Names of the sides of the grid with contact. */
    std::vector<std::string> sides;
    double                   stiffness = 10.; ///< times the body's

    /** Declares the entries of contact with sides. */
    explicit ContactSideParameters(
      const std::string &section = "Boundary conditions");

    /** Whether any side has contact. */
    bool
    are_present() const
    {
      return !sides.empty();
    }

    /** See EffectParameters::least_threshold(). */
    template <int dim>
    double
    least_threshold() const;

    /** Throws ExcParameter. */
    template <int dim>
    void
    add_to(const BackgroundGrid<dim>     &grid,
           const BoundaryConditions<dim> &boundary_conditions,
           Effects<dim>                  &effects,
           FieldLayout                   &layout) const;
  };

  /** Its columns are those of the sides. */
  template <int dim>
  EffectCard
  contact_sides_card(const ContactSideParameters &parameters);
} // namespace emmy

#endif
