#include <deal.II/numerics/rtree.h>

#include <emmy/effects/contact_search.h>

#include <algorithm>
#include <cmath>

namespace emmy
{
  using dealii::Tensor;
  namespace bgi = boost::geometry::index;

  template <int dim>
  Tensor<1, dim>
  ContactRules<dim>::point(const unsigned int body, unsigned int index) const
  {
    Tensor<1, dim> result = bodies[body].half_length;
    for (unsigned int d = 0; d < dim; ++d, index /= points_per_direction)
      result[d] *=
        (2. * (index % points_per_direction) + 1.) / points_per_direction - 1.;
    return result;
  }

  template <int dim>
  PairLaw
  ContactRules<dim>::law(const unsigned int first,
                         const unsigned int second) const
  {
    const ContactBody<dim> &one = bodies[first], &two = bodies[second];
    const double            between =
      0.5 * (one.spacing + two.spacing) / points_per_direction; // s_c
    const double modulus =
      2. * one.modulus * two.modulus / (one.modulus + two.modulus);
    const double k = stiffness * modulus * std::pow(between, dim - 2);
    return {k,
            radius * between,
            exponent,
            one.spacing / (one.spacing + two.spacing),
            friction,
            spring_stiffness * k};
  }

  template <int dim>
  double
  ContactRules<dim>::largest_reach() const
  {
    double largest = 0.;
    for (const ContactBody<dim> &body : bodies)
      if (body.group != body.none)
        largest = std::max(largest, body.spacing);
    return radius * largest / points_per_direction;
  }

  template <int dim>
  double
  ContactParticle<dim>::arm(const ContactBody<dim> &of_body) const
  {
    double sum = 0.;
    for (unsigned int d = 0; d < dim; ++d)
      {
        Tensor<1, dim> xi;
        xi[d] = of_body.half_length[d];
        sum += (F * xi).norm();
      }
    return sum;
  }

  namespace
  {
    template <int dim>
    using Box = dealii::BoundingBox<dim>;

    /** The particles that are near to the box around another group. */
    template <int dim>
    std::vector<unsigned int>
    near_others(const ContactRules<dim>                 &rules,
                const std::vector<ContactParticle<dim>> &particles,
                const double                             distance)
    {
      std::vector<std::vector<dealii::Point<dim>>> of_groups;
      for (const ContactParticle<dim> &particle : particles)
        {
          const unsigned int group = rules.bodies[particle.body].group;
          if (of_groups.size() <= group)
            of_groups.resize(group + 1);
          of_groups[group].push_back(particle.place);
        }
      std::vector<Box<dim>> boxes(of_groups.size());
      for (unsigned int g = 0; g < boxes.size(); ++g)
        if (!of_groups[g].empty())
          {
            boxes[g] = Box<dim>(of_groups[g]);
            boxes[g].extend(distance);
          }
      std::vector<unsigned int> result;
      for (unsigned int i = 0; i < particles.size(); ++i)
        for (unsigned int g = 0; g < boxes.size(); ++g)
          if (g != rules.bodies[particles[i].body].group &&
              !of_groups[g].empty() &&
              boxes[g].point_inside(particles[i].place))
            {
              result.push_back(i);
              break;
            }
      return result;
    }

    /** A particle with its contact points. */
    template <int dim>
    struct Reaching
    {
      const ContactParticle<dim> &particle;
      double                      arm;    ///< m
      std::vector<Tensor<1, dim>> points; ///< m

      Reaching(const ContactRules<dim>    &rules,
               const ContactParticle<dim> &particle)
        : particle(particle)
        , arm(particle.arm(rules.bodies[particle.body]))
      {
        points.reserve(rules.n_points());
        for (unsigned int i = 0; i < rules.n_points(); ++i)
          points.push_back(particle.place +
                           particle.F * rules.point(particle.body, i));
      }
    };

    /** The contact points of two particles that may touch. */
    template <int dim>
    std::vector<std::array<unsigned char, 2>>
    near_points(const ContactRules<dim> &rules,
                const Reaching<dim>     &one,
                const Reaching<dim>     &two,
                const double             margin)
    {
      std::vector<std::array<unsigned char, 2>> result;
      const double                              reach =
        rules.reach(one.particle.body, two.particle.body) + margin;
      const double farthest = reach + one.arm + two.arm;
      if ((one.particle.place - two.particle.place).norm_square() >=
          farthest * farthest)
        return result;
      const double to_any = reach + (1. + 1e-12) * two.arm;
      for (unsigned int i = 0; i < one.points.size(); ++i)
        {
          if ((one.points[i] - two.particle.place).norm_square() >=
              to_any * to_any)
            continue;
          for (unsigned int j = 0; j < two.points.size(); ++j)
            if ((one.points[i] - two.points[j]).norm_square() < reach * reach)
              result.push_back({{static_cast<unsigned char>(i),
                                 static_cast<unsigned char>(j)}});
        }
      return result;
    }

    /** Leave out particles that are in no pair. */
    template <int dim>
    void
    leave_out_lone(Candidates<dim> &found)
    {
      std::vector<char> is_used(found.particles.size(), false);
      for (const ParticlePair &pair : found.pairs)
        is_used[pair.first] = is_used[pair.second] = true;
      std::vector<unsigned int>         now(found.particles.size());
      std::vector<ContactParticle<dim>> used;
      for (unsigned int i = 0; i < is_used.size(); ++i)
        if (is_used[i])
          {
            now[i] = used.size();
            used.push_back(found.particles[i]);
          }
      found.particles = std::move(used);
      for (ParticlePair &pair : found.pairs)
        {
          pair.first  = now[pair.first];
          pair.second = now[pair.second];
        }
    }
  } // namespace

  template <int dim>
  Candidates<dim>
  find_candidates(const ContactRules<dim>          &rules,
                  std::vector<ContactParticle<dim>> particles,
                  const double                      margin,
                  const unsigned int                rank)
  {
    // neither the order of cells nor the partition may matter
    std::sort(particles.begin(),
              particles.end(),
              [](const auto &a, const auto &b) { return a.id < b.id; });
    Candidates<dim> found;
    found.particles    = std::move(particles);
    double largest_arm = 0.;
    for (const ContactParticle<dim> &particle : found.particles)
      largest_arm =
        std::max(largest_arm, particle.arm(rules.bodies[particle.body]));
    const double distance = rules.largest_reach() + margin + 2. * largest_arm;

    const auto near = near_others(rules, found.particles, distance);
    std::vector<std::pair<dealii::Point<dim>, unsigned int>> places;
    std::vector<Reaching<dim>>                               reaching;
    reaching.reserve(near.size());
    for (unsigned int n = 0; n < near.size(); ++n)
      {
        places.emplace_back(found.particles[near[n]].place, n);
        reaching.emplace_back(rules, found.particles[near[n]]);
      }
    const auto tree = dealii::pack_rtree(places);
    std::vector<std::pair<dealii::Point<dim>, unsigned int>> around;
    for (unsigned int n = 0; n < near.size(); ++n)
      {
        const ContactParticle<dim> &one = found.particles[near[n]];
        Box<dim>                    box({one.place, one.place});
        box.extend(distance);
        around.clear();
        tree.query(bgi::intersects(box), std::back_inserter(around));
        std::sort(around.begin(),
                  around.end(),
                  [](const auto &a, const auto &b) {
                    return a.second < b.second;
                  });
        for (const auto &[place, m] : around)
          {
            (void)place;
            const ContactParticle<dim> &two = found.particles[near[m]];
            if (m <= n ||
                rules.bodies[one.body].group == rules.bodies[two.body].group ||
                (one.owner != rank && two.owner != rank))
              continue;
            auto points = near_points(rules, reaching[n], reaching[m], margin);
            if (!points.empty())
              found.pairs.push_back({near[n], near[m], std::move(points)});
          }
      }
    leave_out_lone(found);
    return found;
  }

#define INSTANTIATE(dim)                         \
  template struct ContactRules<dim>;             \
  template struct ContactParticle<dim>;          \
  template Candidates<dim> find_candidates<dim>( \
    const ContactRules<dim> &,                   \
    std::vector<ContactParticle<dim>>,           \
    const double,                                \
    const unsigned int);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
