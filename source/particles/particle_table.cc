#include <deal.II/base/patterns.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/text.h>
#include <emmy/particles/particle_table.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
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

    /** The words of a line, whatever separates them. */
    std::vector<std::string>
    words_of(std::string line)
    {
      std::replace_if(
        line.begin(),
        line.end(),
        [](const char letter) {
          return letter == ',' || letter == ';' || letter == '\t' ||
                 letter == '\r';
        },
        ' ');
      std::istringstream       stream(line);
      std::vector<std::string> words;
      for (std::string word; stream >> word;)
        words.push_back(word);
      return words;
    }

    /** Columns of a file, by their names. */
    class Columns
    {
    public:
      Columns(const std::vector<std::string> &names,
              const std::vector<std::string> &known)
        : names(names)
      {
        for (const std::string &name : known)
          {
            const auto found = std::find(names.begin(), names.end(), name);
            places.push_back(found == names.end() ? -1 : found - names.begin());
          }
        for (const std::string &name : names)
          if (problem.empty())
            {
              if (std::count(known.begin(), known.end(), name) == 0)
                problem = "unknown column <" + name + ">";
              else if (std::count(names.begin(), names.end(), name) > 1)
                problem = "two columns <" + name + ">";
            }
      }

      bool
      has(const unsigned int column) const
      {
        return places[column] >= 0;
      }

      double
      operator()(const std::vector<double> &line,
                 const unsigned int         column) const
      {
        return line[places[column]];
      }

      const std::vector<std::string> names;
      std::string                    problem;

    private:
      std::vector<int> places;
    };

    /** Of a line; empty where a word is no finite number. */
    std::vector<double>
    numbers_in(const std::vector<std::string> &words)
    {
      std::vector<double> numbers;
      for (const std::string &word : words)
        {
          char *end = nullptr;
          numbers.push_back(std::strtod(word.c_str(), &end));
          if (*end != '\0' || !std::isfinite(numbers.back()))
            return {};
        }
      return numbers;
    }
  } // namespace

  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_particle_table(const std::string &file, const std::string &section)
  {
    const auto require = [&](const bool condition, const std::string &what) {
      AssertThrow(condition, ExcParameter(section, "File", file, what));
    };
    std::ifstream in(file);
    require(in.good(),
            "there is no such file to read; a name without / in front counts "
            "from the folder in which emmy is started.");
    std::vector<std::string> known{"x", "y", "z"};
    known.resize(dim);
    known.push_back("volume");
    for (unsigned int d = 0; d < dim; ++d)
      known.push_back(std::string("v") + "xyz"[d]);
    const std::string usage =
      " Its first line names its columns: " + join(known) +
      "; velocities are optional.";

    std::unique_ptr<Columns> columns;
    ParticleTable<dim>       table;
    unsigned int             n_lines = 0;
    for (std::string line; std::getline(in, line);)
      {
        ++n_lines;
        const auto words = words_of(line);
        if (words.empty() || words[0][0] == '#')
          continue;
        const std::string where = "line " + std::to_string(n_lines) + ": ";
        if (!columns)
          {
            columns = std::make_unique<Columns>(words, known);
            require(columns->problem.empty(),
                    where + columns->problem + "." + usage);
            for (unsigned int c = 0; c <= dim; ++c)
              require(columns->has(c),
                      where + "no column <" + known[c] + ">." + usage);
            for (unsigned int d = 1; d < dim; ++d)
              require(columns->has(dim + 1) == columns->has(dim + 1 + d),
                      where + "give all components of the velocity, or none." +
                        usage);
            continue;
          }
        const auto numbers = numbers_in(words);
        require(numbers.size() == columns->names.size(),
                where + "it should hold " +
                  std::to_string(columns->names.size()) +
                  " finite numbers, one a column.");
        Point<dim>             position;
        dealii::Tensor<1, dim> velocity;
        for (unsigned int d = 0; d < dim; ++d)
          {
            position[d] = (*columns)(numbers, d);
            if (columns->has(dim + 1))
              velocity[d] = (*columns)(numbers, dim + 1 + d);
          }
        const double volume = (*columns)(numbers, dim);
        require(volume > 0., where + "the volume must be positive.");
        table.positions.push_back(position);
        table.volumes.push_back(volume);
        if (columns->has(dim + 1))
          table.velocities.push_back(velocity);
      }
    require(!table.positions.empty(), "it lists no particle." + usage);
    return std::make_unique<ListedParticles<dim>>(std::move(table));
  }

  template std::unique_ptr<Shape<2>>
  read_particle_table<2>(const std::string &, const std::string &);
  template std::unique_ptr<Shape<3>>
  read_particle_table<3>(const std::string &, const std::string &);
} // namespace emmy
