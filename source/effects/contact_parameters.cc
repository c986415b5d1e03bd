#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/effects/contact_parameters.h>

#include <algorithm>

namespace emmy
{
  using dealii::Patterns::Double;
  using dealii::Patterns::Integer;

  template <int dim>
  ContactParameters<dim>::ContactParameters(const std::string &section)
    : EffectParameters<dim>(section)
  {
    this->add_parameter("Groups",
                        groups,
                        "Groups of bodies that push one another, separated by "
                        "|; the bodies of a group, separated by commas, stick "
                        "together where they meet, as bodies without contact "
                        "do. Bodies that are in no group go through all "
                        "groups. E.g. hammer | nail, board. Required.");
    this->add_parameter("Friction coefficient",
                        friction,
                        "mu of Coulomb's law. 0: smooth. Dimensionless, not "
                        "negative.",
                        this->prm,
                        Double());
    this->add_parameter("Friction stiffness",
                        spring_stiffness,
                        "Of the springs that what sticks is held by, in those "
                        "of contact. Dimensionless, positive.",
                        this->prm,
                        Double());
    this->add_parameter("Radius",
                        radius,
                        "How far contact points reach, in their mean spacing. "
                        "Small ones find bumps where bodies slide: friction "
                        "that nobody wants. Dimensionless, positive.",
                        this->prm,
                        Double());
    this->add_parameter("Exponent",
                        exponent,
                        "q of the energy k/q p^q / reach^(q-2) of two points "
                        "that are nearer than their reach by p. 2 to 6.",
                        this->prm,
                        Integer(2, 6));
    this->add_parameter("Points per direction",
                        points_per_direction,
                        "Contact points of a particle, per direction. 1 is "
                        "enough with 8 or more particles per direction of a "
                        "cell. 1 to 4.",
                        this->prm,
                        Integer(1, 4));
    this->add_parameter("Stiffness factor",
                        stiffness,
                        "beta of k = beta M s^(d-2), with the P-wave modulus "
                        "M of the bodies, the spacing s of contact points and "
                        "the dimension d. Less than 0.1 lets bodies sink into "
                        "one another; 0: they go through one another. "
                        "Dimensionless, not negative.",
                        this->prm,
                        Double());
  }

  template <int dim>
  typename ContactParameters<dim>::Groups
  ContactParameters<dim>::split_groups() const
  {
    Groups result;
    for (const std::string &group :
         dealii::Utilities::split_string_list(groups, '|'))
      result.push_back(dealii::Utilities::split_string_list(group));
    return result;
  }

  template <int dim>
  void
  ContactParameters<dim>::check_numbers() const
  {
    const auto require = [this](const bool         fact,
                                const std::string &entry,
                                const double       value,
                                const std::string &what) {
      AssertThrow(fact,
                  ExcParameter(this->path(), entry, shortest(value), what));
    };
    require(friction >= 0.,
            "Friction coefficient",
            friction,
            "must not be negative. 0: smooth.");
    require(spring_stiffness > 0.,
            "Friction stiffness",
            spring_stiffness,
            "must be positive; 1 is good.");
    require(radius > 0., "Radius", radius, "must be positive; 2.5 is good.");
    require(stiffness >= 0.,
            "Stiffness factor",
            stiffness,
            "must not be negative; 1 is good.");
  }

  template <int dim>
  std::vector<unsigned int>
  ContactParameters<dim>::groups_of(const std::vector<std::string> &names) const
  {
    const auto require = [this](const bool fact, const std::string &what) {
      AssertThrow(fact, ExcParameter(this->path(), "Groups", groups, what));
    };
    const Groups              listed = split_groups();
    std::vector<unsigned int> result(names.size(), ContactBody<dim>::none);
    require(listed.size() >= 2,
            "at least two groups of bodies are required, separated by |.");
    for (unsigned int group = 0; group < listed.size(); ++group)
      {
        require(!listed[group].empty() && !listed[group].front().empty(),
                "a group has no body.");
        for (const std::string &name : listed[group])
          {
            const auto found = std::find(names.begin(), names.end(), name);
            const std::string nearest = nearest_name(name, names);
            require(found != names.end(),
                    "there is no body <" + name + ">. " +
                      (nearest.empty() ? std::string()
                                       : "Did you mean <" + nearest + ">? ") +
                      "Known are: " + join(names) + ".");
            unsigned int &of_body = result[found - names.begin()];
            require(of_body == ContactBody<dim>::none,
                    "the body <" + name + "> is named twice.");
            of_body = group;
          }
      }
    return result;
  }

  template <int dim>
  std::vector<std::string>
  ContactParameters<dim>::group_names() const
  {
    std::vector<std::string> result;
    for (const auto &group : split_groups())
      if (!group.empty())
        result.push_back(group.front());
    return result;
  }

  template <int dim>
  void
  ContactParameters<dim>::add_to(Effects<dim> &effects,
                                 FieldLayout  &layout) const
  {
    check_numbers();
    const auto groups = groups_of(effects.body_names);
    // bodies of no group share a field, if there are any
    const unsigned int first =
      std::count(groups.begin(), groups.end(), ContactBody<dim>::none) > 0;
    effects.field_of_body.clear();
    for (const unsigned int group : groups)
      effects.field_of_body.push_back(
        group == ContactBody<dim>::none ? 0 : first + group);
    if (stiffness == 0.)
      return;

    const auto                    corners = corners_of_bodies(effects);
    std::vector<ContactBody<dim>> bodies;
    for (unsigned int b = 0; b < groups.size(); ++b)
      bodies.push_back({corners[b].half_length,
                        corners[b].spacing,
                        effects.material_of_body[b]->p_wave_modulus(),
                        groups[b]});
    const typename BodyContact<dim>::Fields fields{
      layout["body"], layout.add(deformation_gradient_field<dim>())};
    effects.terms.push_back(
      std::make_unique<BodyContact<dim>>(ContactRules<dim>{std::move(bodies),
                                                           radius,
                                                           exponent,
                                                           points_per_direction,
                                                           stiffness,
                                                           friction,
                                                           spring_stiffness},
                                         group_names(),
                                         fields,
                                         corners));
  }

  template <int dim>
  EffectCard
  ContactParameters<dim>::card()
  {
    EffectCard card;
    card.enters  = "stencils: nodes of their own for each group of bodies; "
                   "Newton: forces between points of particles that are near";
    card.couples = "the nodes of particles of two groups that may touch";
    card.fields  = {deformation_gradient_field<dim>()};
    card.ledger_columns = {"contact_energy", "contact_overlap_work"};
    for (const std::string &column : BodyContact<dim>::columns_of({"BODY"}))
      card.ledger_columns.push_back(column);
    return card;
  }

  template <int dim>
  EffectCard
  ContactParameters<dim>::card_in_scene(const EffectCard &of_library) const
  {
    EffectCard card = of_library;
    card.ledger_columns.clear();
    if (stiffness == 0.)
      {
        card.fields.clear();
        return card;
      }
    card.ledger_columns = {"contact_energy"};
    if (friction > 0.)
      card.ledger_columns.insert(card.ledger_columns.end(),
                                 {"friction_energy", "friction_dissipation"});
    card.ledger_columns.push_back("contact_overlap_work");
    for (const std::string &column :
         BodyContact<dim>::columns_of(group_names()))
      card.ledger_columns.push_back(column);
    return card;
  }

  template class ContactParameters<2>;
  template class ContactParameters<3>;
} // namespace emmy
