#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/particles/particle_table.h>

#include <boost/algorithm/string/predicate.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numeric>

namespace emmy
{
  using dealii::BoundingBox;
  using dealii::Point;

  namespace
  {
    template <int dim>
    class ListedParticles : public Shape<dim>
    {
    public:
      explicit ListedParticles(ParticleTable<dim> particles)
        : particles(std::move(particles))
        , total(std::accumulate(this->particles.volumes.begin(),
                                this->particles.volumes.end(),
                                0.))
        , half(0.5 * std::pow(total / this->particles.volumes.size(), 1. / dim))
        , order(this->particles.positions)
      {
        std::sort(order.begin(), order.end(), [](const auto &a, const auto &b) {
          return a[0] < b[0];
        });
      }

      bool
      contains(const Point<dim> &position) const override
      {
        const auto first = std::lower_bound(order.begin(),
                                            order.end(),
                                            position[0] - half,
                                            [](const auto &x, const double at) {
                                              return x[0] < at;
                                            });
        for (auto x = first; x != order.end() && (*x)[0] <= position[0] + half;
             ++x)
          {
            bool is_inside = true;
            for (unsigned int d = 0; d < dim; ++d)
              is_inside = is_inside && std::abs((*x)[d] - position[d]) <= half;
            if (is_inside)
              return true;
          }
        return false;
      }

      double
      volume() const override
      {
        return total;
      }

      const ParticleTable<dim> *
      table() const override
      {
        return &particles;
      }

      /** Of the centres: boxes may stick out of the grid. */
      BoundingBox<dim>
      bounding_box() const override
      {
        Point<dim> lower = order[0], upper = order[0];
        for (const Point<dim> &x : order)
          for (unsigned int d = 0; d < dim; ++d)
            {
              lower[d] = std::min(lower[d], x[d]);
              upper[d] = std::max(upper[d], x[d]);
            }
        return BoundingBox<dim>({lower, upper});
      }

    private:
      const ParticleTable<dim> particles;
      const double             total, half;
      std::vector<Point<dim>>  order; ///< by x
    };

    /** Keep the rows of one body, if the file has several. */
    template <class Require>
    void
    choose_rows(const TableFile &from,
                ParticleColumns &all,
                const Require   &require)
    {
      const int column = all.find("body");
      require(from.body < 0 || column >= 0,
              "it has no column <body> by which <Rows of body> could choose");
      if (column < 0)
        return;
      auto &rows = all.rows;
      if (from.body >= 0)
        rows.erase(std::remove_if(rows.begin(),
                                  rows.end(),
                                  [&](const auto &row) {
                                    return row[column] != from.body;
                                  }),
                   rows.end());
      for (const auto &row : rows)
        require(row[column] == rows[0][column],
                "it has particles of several bodies, by its column <body>. Set "
                "<Rows of body> to the number of one of them, from 0");
    }

    /** By how much its motion has changed the volume of a row; 1: unknown. */
    template <int dim>
    double
    volume_ratio(const ParticleColumns &all, const std::vector<double> &row)
    {
      const auto at = [&](const std::string &name) {
        const int column = all.find(name);
        return column < 0 ? 0. : row[column];
      };
      if (all.find("logarithmic_strain_xx") >= 0)
        return std::exp(at("logarithmic_strain_xx") +
                        at("logarithmic_strain_yy") +
                        at("logarithmic_strain_zz"));
      if (all.find("left_cauchy_green_xx") < 0)
        return 1.;
      const auto b = [&](const char *ij) {
        return at(std::string("left_cauchy_green_") + ij);
      };
      const double zz = all.find("left_cauchy_green_zz") < 0 ? 1. : b("zz");
      return std::sqrt(zz * (b("xx") * b("yy") - b("xy") * b("xy")) +
                       2. * b("xy") * b("xz") * b("yz") -
                       b("xx") * b("yz") * b("yz") -
                       b("yy") * b("xz") * b("xz"));
    }

    /** Columns that every body has, by all names under which they come. */
    template <int dim>
    struct BasicColumns
    {
      std::vector<int> position, velocity;
      int              volume, reference_volume, mass, density;

      explicit BasicColumns(const ParticleColumns &all)
        : volume(all.find("volume"))
        , reference_volume(all.find("reference_volume"))
        , mass(all.find("mass"))
        , density(all.find("density"))
      {
        for (unsigned int d = 0; d < dim; ++d)
          {
            const std::string axis(1, "xyz"[d]);
            position.push_back(all.find(axis));
            velocity.push_back(all.find("v" + axis) >= 0
                                 ? all.find("v" + axis)
                                 : all.find("velocity_" + axis));
          }
      }

      /** @return what is wrong; empty: nothing */
      std::string
      problem() const
      {
        for (unsigned int d = 0; d < dim; ++d)
          {
            if (position[d] < 0)
              return std::string("no column <") + "xyz"[d] + ">";
            if ((velocity[d] < 0) != (velocity[0] < 0))
              return "give all components of the velocity, or none";
          }
        if (volume < 0 && reference_volume < 0)
          return "no column <volume>";
        if (mass >= 0 && density >= 0)
          return "both <mass> and <density>; leave one of them out";
        return "";
      }

      /** Whether a column is one of these. */
      bool
      has(const int column) const
      {
        const std::vector<int> others{volume, reference_volume, mass, density};
        for (const auto &list : {position, velocity, others})
          if (std::count(list.begin(), list.end(), column) > 0)
            return true;
        return false;
      }
    };

    /** Sort the columns of the rows. Throws by @p require. */
    template <int dim, class Require>
    ParticleTable<dim>
    table_of(const TableFile       &from,
             const ParticleColumns &all,
             const Require         &require)
    {
      const BasicColumns<dim> basic(all);
      const std::string       usage =
        ". Its columns are named in its first line: x, y" +
        std::string(dim == 2 ? "" : ", z") +
        ", volume and, if wanted, velocity, mass or density, and state";
      require(basic.problem().empty(), basic.problem() + usage);
      require(!all.rows.empty(), "it lists no particle" + usage);
      ParticleTable<dim> table;
      table.from = from;
      std::vector<unsigned int> others;
      for (unsigned int c = 0; c < all.names.size(); ++c)
        if (const std::string &name = all.names[c];
            !basic.has(c) && name != "body" && !(dim == 2 && name == "z") &&
            std::count(from.left_out.begin(), from.left_out.end(), name) == 0)
          {
            others.push_back(c);
            table.state.names.push_back(name);
          }
      for (const auto &row : all.rows)
        {
          Point<dim>             position;
          dealii::Tensor<1, dim> velocity;
          for (unsigned int d = 0; d < dim; ++d)
            {
              position[d] = row[basic.position[d]];
              velocity[d] = basic.velocity[d] < 0 ? 0. : row[basic.velocity[d]];
            }
          const double volume =
            basic.volume >= 0
              ? row[basic.volume]
              : row[basic.reference_volume] * volume_ratio<dim>(all, row);
          const std::string where =
            "particle at (" + dealii::Patterns::Tools::to_string(position) +
            "): ";
          require(volume > 0., where + "the volume must be positive");
          table.positions.push_back(position);
          table.volumes.push_back(volume);
          if (basic.velocity[0] >= 0)
            table.velocities.push_back(velocity);
          if (basic.mass >= 0 || basic.density >= 0)
            {
              table.masses.push_back(basic.mass >= 0
                                       ? row[basic.mass]
                                       : row[basic.density] * volume);
              require(table.masses.back() > 0.,
                      where + "the mass must be positive");
            }
          auto &state = table.state.rows.emplace_back();
          for (const unsigned int c : others)
            state.push_back(row[c]);
        }
      return table;
    }
  } // namespace

  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_particle_table(const TableFile &from)
  {
    const auto require = [&](const bool condition, const std::string &what) {
      AssertThrow(condition,
                  ExcParameter(from.section, "File", from.file, what + "."));
    };
    require(std::ifstream(from.file).good(),
            "there is no such file to read; a name without / in front counts "
            "from the folder in which emmy is started");
    ParticleColumns all = boost::iends_with(from.file, "vtu")
                            ? read_vtu_columns(from.file)
                            : read_text_columns(from.file);
    require(all.problem.empty(), all.problem);
    choose_rows(from, all, require);
    return std::make_unique<ListedParticles<dim>>(
      table_of<dim>(from, all, require));
  }

  template std::unique_ptr<Shape<2>>
  read_particle_table<2>(const TableFile &);
  template std::unique_ptr<Shape<3>>
  read_particle_table<3>(const TableFile &);
} // namespace emmy
