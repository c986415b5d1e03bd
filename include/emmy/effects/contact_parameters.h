#ifndef emmy_effects_contact_parameters_h
#define emmy_effects_contact_parameters_h

#include <emmy/effects/body_contact.h>

namespace emmy
{
  /** Section `Effects/Contact`. */
  template <int dim>
  class ContactParameters : public EffectParameters<dim>
  {
  public:
    /** Declares the entries of a section. */
    explicit ContactParameters(const std::string &section);

    void
    add_to(Effects<dim> &effects, FieldLayout &layout) const override;

    /** Each body has its own thinly filled nodes, and only a layer is pushed.
     */
    double
    least_threshold() const override
    {
      return 0.1;
    }

    /** What `emmy --check` says of it. */
    static EffectCard
    card();
    EffectCard
    card_in_scene(const EffectCard &of_library) const override;

  private:
    using Groups = std::vector<std::vector<std::string>>;

    /** Names of bodies, group by group. */
    Groups
    split_groups() const;
    void
    check_numbers() const;
    /** The group of each body; throws ExcParameter. */
    std::vector<unsigned int>
    groups_of(const std::vector<std::string> &body_names) const;
    /** Names in the ledger: of the first body of each group. */
    std::vector<std::string>
    group_names() const;

    std::string  groups;
    double       friction = 0., spring_stiffness = 1.;
    double       radius = 2.5, stiffness = 1.;
    unsigned int exponent = 3, points_per_direction = 2;
  };
} // namespace emmy

#endif
