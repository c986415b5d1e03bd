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

    /** The particles that are near to the box around another group, by id. */
    template <int dim>
    std::vector<ContactParticle<dim>>
    near_others(const ContactRules<dim>                 &rules,
                const std::vector<ContactParticle<dim>> &particles,
                const double                             distance)
    {
      constexpr double all = std::numeric_limits<double>::max();
      // by group and direction, of the group's box
      std::vector<std::array<std::array<double, 2>, dim>> boxes;
      for (const ContactParticle<dim> &particle : particles)
        {
          const unsigned int group = rules.bodies[particle.body].group;
          while (boxes.size() <= group)
            {
              boxes.emplace_back();
              boxes.back().fill({{all, -all}}); // none yet
            }
          for (unsigned int d = 0; d < dim; ++d)
            {
              auto &[lower, upper] = boxes[group][d];
              lower                = std::min(lower, particle.place[d]);
              upper                = std::max(upper, particle.place[d]);
            }
        }
      const auto is_near = [&](const ContactParticle<dim> &particle) {
        for (unsigned int g = 0; g < boxes.size(); ++g)
          {
            bool is_inside = g != rules.bodies[particle.body].group;
            for (unsigned int d = 0; d < dim && is_inside; ++d)
              is_inside = particle.place[d] >= boxes[g][d][0] - distance &&
                          particle.place[d] <= boxes[g][d][1] + distance;
            if (is_inside)
              return true;
          }
        return false;
      };
      std::vector<ContactParticle<dim>> result;
      std::copy_if(particles.begin(),
                   particles.end(),
                   std::back_inserter(result),
                   is_near);
      std::sort(result.begin(), result.end(), [](const auto &a, const auto &b) {
        return a.id < b.id;
      });
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
    void
    near_points(const ContactRules<dim>                   &rules,
                const Reaching<dim>                       &one,
                const Reaching<dim>                       &two,
                const double                               margin,
                std::vector<std::array<unsigned char, 2>> &result)
    {
      result.clear();
      const double reach =
        rules.reach(one.particle.body, two.particle.body) + margin;
      const double farthest = reach + one.arm + two.arm;
      if ((one.particle.place - two.particle.place).norm_square() >=
          farthest * farthest)
        return;
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
  find_candidates(const ContactRules<dim>                 &rules,
                  const std::vector<ContactParticle<dim>> &particles,
                  const double                             margin,
                  const unsigned int                       rank)
  {
    double largest_arm = 0.;
    for (const ContactParticle<dim> &particle : particles)
      largest_arm =
        std::max(largest_arm, particle.arm(rules.bodies[particle.body]));
    const double reach = rules.largest_reach() + margin;
    // by id: neither the order of cells nor the partition may matter
    Candidates<dim> found;
    found.particles  = near_others(rules, particles, reach + 2. * largest_arm);
    const auto &near = found.particles;

    using Place = std::pair<dealii::Point<dim>, unsigned int>;
    std::vector<Place>         places, around;
    std::vector<Reaching<dim>> reaching;
    reaching.reserve(near.size());
    for (unsigned int n = 0; n < near.size(); ++n)
      {
        places.emplace_back(near[n].place, n);
        reaching.emplace_back(rules, near[n]);
      }
    const auto                                tree = dealii::pack_rtree(places);
    std::vector<std::array<unsigned char, 2>> points;
    for (unsigned int n = 0; n < near.size(); ++n)
      {
        const unsigned int group  = rules.bodies[near[n].body].group;
        const bool         is_own = near[n].owner == rank;
        const auto         is_new = [&](const Place &other) {
          const ContactParticle<dim> &two = near[other.second];
          return other.second > n && rules.bodies[two.body].group != group &&
                 (is_own || two.owner == rank);
        };
        Box<dim> box({near[n].place, near[n].place});
        box.extend(reach + reaching[n].arm + largest_arm);
        around.clear();
        tree.query(bgi::intersects(box) && bgi::satisfies(is_new),
                   std::back_inserter(around));
        std::sort(around.begin(),
                  around.end(),
                  [](const auto &a, const auto &b) {
                    return a.second < b.second;
                  });
        for (const Place &other : around)
          {
            near_points(
              rules, reaching[n], reaching[other.second], margin, points);
            if (!points.empty())
              found.pairs.push_back({n, other.second, points});
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
    const std::vector<ContactParticle<dim>> &,   \
    const double,                                \
    const unsigned int);
  INSTANTIATE(2)
  INSTANTIATE(3)
#undef INSTANTIATE
} // namespace emmy
