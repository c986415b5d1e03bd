#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/base/text.h>
#include <emmy/effects/point_load.h>
#include <emmy/particles/nearest.h>

#include <algorithm>
#include <limits>

namespace emmy
{
  using dealii::Point;

  namespace
  {
    /** "point load on 3 particles" */
    std::string
    load_on(const std::size_t n_particles)
    {
      return "point load on " + std::to_string(n_particles) +
             (n_particles == 1 ? " particle" : " particles");
    }

    /**
     * Gives one share to the particle that is nearest to each position; equally
     * near ones part it equally, so that a load in the middle stays there,
     * whatever the order of the particles. Cost: particles times positions,
     * three times.
     */
    template <int dim>
    class SharesAtPositions : public Effect<dim>
    {
    public:
      SharesAtPositions(const std::vector<Point<dim>> &positions,
                        const std::string             &section,
                        const unsigned int             component)
        : positions(positions)
        , section(section)
        , component(component)
      {}

      std::string
      mark(const BackgroundGrid<dim>               &grid,
           dealii::Particles::ParticleHandler<dim> &particles) const override
      {
        const NearestParticles<dim> nearest(
          positions, section, "Points nearest to", grid, particles);
        const auto n_nearest = nearest.numbers(particles);

        // particles that hold a share, and those that hold several
        std::vector<unsigned int> n_holders(2);
        for (auto &particle : particles)
          {
            double       sum = 0.;
            unsigned int n   = 0;
            for (unsigned int i = 0; i < positions.size(); ++i)
              if (nearest.is_nearest(i, particle.get_location()))
                {
                  sum += 1. / n_nearest[i];
                  ++n;
                }
            particle.get_properties()[component] = sum / positions.size();
            n_holders[0] += n > 0;
            n_holders[1] += n > 1;
          }
        dealii::Utilities::MPI::sum(n_holders, grid.communicator(), n_holders);
        const auto &distances = nearest.distances();
        const auto  farthest =
          std::max_element(distances.begin(), distances.end());
        const bool is_parted =
          *std::max_element(n_nearest.begin(), n_nearest.end()) > 1;
        return load_on(n_holders[0]) +
               (n_holders[1] > 0 ? ", some of which hold several shares" : "") +
               (is_parted ? ", equally near ones part a share" : "") +
               (n_holders[0] > 1 ? ", the farthest " : ", ") +
               brief(*farthest) + " m from its position (" +
               dealii::Patterns::Tools::to_string(
                 positions[farthest - distances.begin()]) +
               ") m";
      }

    private:
      const std::vector<Point<dim>> positions;
      const std::string             section;
      const unsigned int            component;
    };

    /** Gives equal shares to all particles where a formula is positive. */
    template <int dim>
    class ParticlesInside : public Effect<dim>
    {
    public:
      ParticlesInside(const std::string &region,
                      const std::string &section,
                      const unsigned int component)
        : text(region)
        , section(section)
        , remedy("Write a formula in " +
                 dealii::FunctionParser<dim>::default_variable_names() +
                 " that is positive at the particles that hold the load, e.g. "
                 "x - 9.9.")
        , region(read_formulas<dim>(text, 1, section, "Region", remedy))
        , component(component)
      {}

      std::string
      mark(const BackgroundGrid<dim>               &grid,
           dealii::Particles::ParticleHandler<dim> &particles) const override
      {
        unsigned long n_inside = 0;
        for (const auto &particle : particles)
          n_inside += is_inside(particle.get_location());
        n_inside = dealii::Utilities::MPI::sum(n_inside, grid.communicator());
        AssertThrow(n_inside > 0,
                    ExcParameter(section,
                                 "Region",
                                 text,
                                 "no particle is inside at the start. " +
                                   remedy));
        const double share = 1. / n_inside;
        for (auto &particle : particles)
          if (is_inside(particle.get_location()))
            particle.get_properties()[component] = share;
        return load_on(n_inside);
      }

    private:
      bool
      is_inside(const Point<dim> &position) const
      {
        return region->value(position) > 0.;
      }

      const std::string                                  text, section, remedy;
      const std::unique_ptr<dealii::FunctionParser<dim>> region;
      const unsigned int                                 component;
    };
  } // namespace

  template <int dim>
  PointLoadParameters<dim>::PointLoadParameters(const std::string &section)
    : EffectParameters<dim>(section)
  {
    using dealii::Patterns::Double;
    using dealii::Patterns::List;
    const unsigned int any = std::numeric_limits<unsigned int>::max();
    this->add_parameter("Force",
                        force,
                        "Components of the whole force, separated by , or ;. "
                        "A scene has one such load. The "
                        "amplitude multiplies it. Unit: N (per metre of "
                        "thickness in plane strain). Required if point load "
                        "is named.",
                        this->prm,
                        List(Double(), 0, dim, ";"));
    this->add_parameter("Points nearest to",
                        positions,
                        "Positions separated by ;, each a list of coordinates "
                        "separated by ,. The particle that is nearest to "
                        "a position at the start gets one share of the force; "
                        "equally near ones part it equally. Unit: m. Either "
                        "this or <Region>.",
                        this->prm,
                        List(List(Double(), dim, dim, ","), 0, any, ";"));
    this->add_parameter("Region",
                        region,
                        "A formula in x, y (and z), in m. The particles where "
                        "it is positive at the start share the force equally. "
                        "Either this or <Points nearest to>.");
    amplitude.declare(*this);
  }

  template <int dim>
  void
  PointLoadParameters<dim>::validate() const
  {
    std::vector<std::string> components;
    for (const double component : force)
      components.push_back(shortest(component));
    AssertThrow(force.size() == dim,
                ExcParameter(this->path(),
                             "Force",
                             join(components, "; "),
                             "it is required: " + std::to_string(dim) +
                               " components in N, separated by , or ;, e.g. " +
                               (dim == 2 ? "0; -500e3." : "0; 0; -500e3.")));
    const bool has_region = !dealii::Utilities::trim(region).empty();
    AssertThrow(!positions.empty() || has_region,
                ExcParameter(this->path(),
                             "Points nearest to",
                             "",
                             "the load needs particles that hold it. Give "
                             "positions, e.g. " +
                               std::string(dim == 2 ? "10, 0.5"
                                                    : "10, 0.5, 0") +
                               ", or <Region>."));
    AssertThrow(positions.empty() || !has_region,
                ExcParameter(this->path(),
                             "Region",
                             region,
                             "<Points nearest to> is given too. Remove one of "
                             "them."));
  }

  template <int dim>
  void
  PointLoadParameters<dim>::add_to(Effects<dim> &effects,
                                   FieldLayout  &layout) const
  {
    validate();
    const unsigned int     share = layout.add(card().fields[0]);
    dealii::Tensor<1, dim> F;
    for (unsigned int d = 0; d < dim; ++d)
      F[d] = force[d];
    effects.terms.push_back(std::make_unique<PointLoad<dim>>(
      F, share, Amplitude(amplitude, this->path())));
    if (positions.empty())
      effects.terms.push_back(
        std::make_unique<ParticlesInside<dim>>(region, this->path(), share));
    else
      effects.terms.push_back(std::make_unique<SharesAtPositions<dim>>(
        positions, this->path(), share));
  }

  template <int dim>
  std::vector<TimeHistory>
  PointLoadParameters<dim>::histories() const
  {
    return {amplitude.history("point load", this->path())};
  }

  template <int dim>
  EffectCard
  PointLoadParameters<dim>::card()
  {
    EffectCard card;
    card.enters         = "loads of the step, before Newton";
    card.fields         = {{"point_load_share",
                            Field::Kind::scalar,
                            "1",
                            "part of the point load that the particle holds"}};
    card.ledger_columns = {"load_work"};
    return card;
  }

  template class PointLoadParameters<2>;
  template class PointLoadParameters<3>;
} // namespace emmy
