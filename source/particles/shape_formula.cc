#include <deal.II/base/utilities.h>

#include <deal.II/physics/transformations.h>

#include <emmy/base/exceptions.h>
#include <emmy/base/formula.h>
#include <emmy/base/text.h>
#include <emmy/particles/basic_shapes.h>
#include <emmy/particles/shape_algebra.h>
#include <emmy/particles/shape_formula.h>
#include <emmy/particles/volume_mesh.h>

#include <cmath>
#include <functional>
#include <map>

namespace emmy
{
  using dealii::Point;
  using dealii::Tensor;

  namespace
  {
    /** The items of a list whose separators are commas and semicolons. */
    std::vector<std::string>
    items_of(const std::string &list)
    {
      std::vector<std::string> items;
      std::string              item;
      int                      depth = 0;
      for (const char letter : list + ";")
        {
          depth += (letter == '(') - (letter == ')');
          if (depth == 0 && (letter == ',' || letter == ';'))
            {
              items.push_back(dealii::Utilities::trim(item));
              item.clear();
            }
          else
            item += letter;
        }
      return items;
    }

    /** Reads the functions of a formula. */
    template <int dim>
    class Reader
    {
    public:
      explicit Reader(const std::string &section)
        : section(section)
      {
        const std::string x     = dim == 2 ? "x, y" : "x, y, z";
        const std::string point = "(" + x + ")";
        add("box",
            "box(lower " + point + "; upper " + point + ")",
            &Reader::box);
        add("ball", "ball(centre " + point + "; radius)", &Reader::ball);
        add("half_space",
            "half_space(point " + point + "; normal " + point +
              "), which the normal leaves",
            &Reader::half_space);
        add("expression",
            "expression(formula in " + x + " that is positive inside)",
            &Reader::expression);
        if (dim == 2)
          add("polygon",
              "polygon(x, y; x, y; x, y; ...), whose edges do not cross",
              &Reader::polygon);
        if (dim == 3)
          {
            add("cylinder",
                "cylinder(base (x, y, z); top (x, y, z); radius)",
                &Reader::cylinder);
            add("cone",
                "cone(base (x, y, z); top (x, y, z); radius of the base; "
                "radius of the top, or none)",
                &Reader::cone);
          }
        add("mesh", "mesh(file; scale, or none)", &Reader::mesh);
        add("union", "union(shape; shape; ...)", &Reader::unite);
        add("intersection",
            "intersection(shape; shape; ...)",
            &Reader::intersect);
        add("difference",
            "difference(shape; what is taken away; ...)",
            &Reader::subtract);
        add("shift", "shift(shape; by " + point + ")", &Reader::shift);
        add("turn",
            dim == 2 ? "turn(shape; degrees; about (x, y))"
                     : "turn(shape; degrees; about (x, y, z); axis (x, y, z))",
            &Reader::turn);
        add("scale",
            "scale(shape; factor), or a factor for each of " + x +
              ", about the origin",
            &Reader::scale);
      }

      std::unique_ptr<Shape<dim>>
      read(const std::string &text) const
      {
        const std::string formula = dealii::Utilities::trim(text);
        const std::size_t open    = formula.find('(');
        require(open != std::string::npos && formula.back() == ')' &&
                  is_closed_at_end(formula, open),
                formula,
                "a shape looks like name(...), with as many ) as (");
        const std::string name =
          dealii::Utilities::trim(formula.substr(0, open));
        const auto found = functions.find(name);
        if (found == functions.end())
          {
            const std::string nearest = nearest_name(name, names());
            require(false,
                    name,
                    (nearest.empty() ? ""
                                     : "did you mean <" + nearest + ">? ") +
                      "Shapes of a formula are " + join(names()));
          }
        const Call call{found->second.usage,
                        items_of(
                          formula.substr(open + 1, formula.size() - open - 2))};
        return (this->*found->second.make)(call);
      }

    private:
      /** A function with its arguments. */
      struct Call
      {
        std::string              usage;
        std::vector<std::string> items;
      };

      using Maker = std::unique_ptr<Shape<dim>> (Reader::*)(const Call &) const;

      struct Function
      {
        std::string usage;
        Maker       make;
      };

      void
      add(const std::string &name, const std::string &usage, const Maker make)
      {
        functions[name] = {usage, make};
      }

      std::vector<std::string>
      names() const
      {
        std::vector<std::string> result;
        for (const auto &function : functions)
          result.push_back(function.first);
        return result;
      }

      static bool
      is_closed_at_end(const std::string &formula, const std::size_t open)
      {
        int depth = 0;
        for (std::size_t i = open; i < formula.size(); ++i)
          {
            depth += (formula[i] == '(') - (formula[i] == ')');
            if (depth == 0)
              return i + 1 == formula.size();
          }
        return false;
      }

      void
      require(const bool         condition,
              const std::string &where,
              const std::string &what) const
      {
        AssertThrow(condition,
                    ExcParameter(section, "Shape", where, what + "."));
      }

      std::string
      written(const Call &call) const
      {
        return join(call.items, "; ");
      }

      /** The numbers from an item on; there must be one of @p counts. */
      std::vector<double>
      numbers(const Call                      &call,
              const unsigned int               first,
              const std::vector<unsigned int> &counts) const
      {
        bool is_right = false;
        for (const unsigned int n : counts)
          is_right = is_right || call.items.size() == first + n;
        require(is_right, written(call), "it should be " + call.usage);
        std::vector<double> result;
        for (unsigned int i = first; i < call.items.size(); ++i)
          {
            const auto formula =
              read_formulas<1>(call.items[i],
                               1,
                               section,
                               "Shape",
                               "A number is expected there: " + call.usage +
                                 ".",
                               "no_variable");
            result.push_back(formula->value(Point<1>()));
            require(std::isfinite(result.back()),
                    call.items[i],
                    "it is no finite number: " + call.usage);
          }
        return result;
      }

      /** @p n shapes from the first item on; 0: all. */
      Shapes<dim>
      shapes(const Call &call, const unsigned int n) const
      {
        Shapes<dim> result;
        for (unsigned int i = 0; i < (n > 0 ? n : call.items.size()); ++i)
          result.push_back(read(call.items[i]));
        return result;
      }

      static Point<dim>
      point(const std::vector<double> &numbers, const unsigned int first)
      {
        Point<dim> result;
        for (unsigned int d = 0; d < dim; ++d)
          result[d] = numbers[first + d];
        return result;
      }

      std::unique_ptr<Shape<dim>>
      box(const Call &call) const
      {
        const auto n     = numbers(call, 0, {2 * dim});
        const auto lower = point(n, 0), upper = point(n, dim);
        for (unsigned int d = 0; d < dim; ++d)
          require(lower[d] < upper[d],
                  written(call),
                  "the upper corner must lie above the lower one in each "
                  "direction: " +
                    call.usage);
        return make_box(lower, upper);
      }

      std::unique_ptr<Shape<dim>>
      ball(const Call &call) const
      {
        const auto n = numbers(call, 0, {dim + 1});
        require(n[dim] > 0., written(call), "its radius must be positive");
        return make_ball(point(n, 0), n[dim]);
      }

      std::unique_ptr<Shape<dim>>
      half_space(const Call &call) const
      {
        const auto n = numbers(call, 0, {2 * dim});
        require(point(n, dim).norm() > 0.,
                written(call),
                "its normal must have a length");
        return make_half_space<dim>(point(n, 0), point(n, dim));
      }

      std::unique_ptr<Shape<dim>>
      expression(const Call &call) const
      {
        require(call.items.size() == 1,
                written(call),
                "it should be " + call.usage);
        return make_expression<dim>(section,
                                    "Shape",
                                    call.items[0],
                                    everywhere<dim>());
      }

      std::unique_ptr<Shape<dim>>
      polygon(const Call &call) const
      {
        if constexpr (dim == 2)
          {
            require(call.items.size() >= 6 && call.items.size() % 2 == 0,
                    written(call),
                    "it should be " + call.usage);
            const unsigned int    count = call.items.size();
            const auto            n     = numbers(call, 0, {count});
            std::vector<Point<2>> corners;
            for (unsigned int i = 0; i < count; i += 2)
              corners.push_back(point(n, i));
            auto result = make_polygon(corners);
            require(result != nullptr,
                    written(call),
                    "its edges must not cross or meet: " + call.usage);
            return result;
          }
        else
          return nullptr;
      }

      std::unique_ptr<Shape<dim>>
      cylinder(const Call &call) const
      {
        auto n = numbers(call, 0, {2 * dim + 1});
        n.push_back(n.back());
        return any_cone(call, n);
      }

      std::unique_ptr<Shape<dim>>
      cone(const Call &call) const
      {
        auto n = numbers(call, 0, {2 * dim + 1, 2 * dim + 2});
        if (n.size() == 2 * dim + 1)
          n.push_back(0.);
        return any_cone(call, n);
      }

      std::unique_ptr<Shape<dim>>
      any_cone(const Call &call, const std::vector<double> &n) const
      {
        require(n[2 * dim] >= 0. && n[2 * dim + 1] >= 0. &&
                  n[2 * dim] + n[2 * dim + 1] > 0.,
                written(call),
                "its radius must be positive: " + call.usage);
        require(point(n, 0) != point(n, dim),
                written(call),
                "base and top must differ: " + call.usage);
        if constexpr (dim == 3)
          return make_cone(point(n, 0), point(n, 3), n[6], n[7]);
        else
          return nullptr;
      }

      std::unique_ptr<Shape<dim>>
      mesh(const Call &call) const
      {
        require(!call.items[0].empty(),
                written(call),
                "it should be " + call.usage);
        const auto n = numbers(call, 1, {0, 1});
        return read_mesh<dim>(
          {call.items[0], n.empty() ? 1. : n[0], "", section, "Shape"});
      }

      std::unique_ptr<Shape<dim>>
      unite(const Call &call) const
      {
        return make_union(shapes(call, 0));
      }

      std::unique_ptr<Shape<dim>>
      intersect(const Call &call) const
      {
        auto result = make_intersection(shapes(call, 0));
        require(result != nullptr, written(call), "these shapes do not meet");
        return result;
      }

      std::unique_ptr<Shape<dim>>
      subtract(const Call &call) const
      {
        require(call.items.size() >= 2,
                written(call),
                "it should be " + call.usage);
        return make_difference(shapes(call, 0));
      }

      std::unique_ptr<Shape<dim>>
      shift(const Call &call) const
      {
        const auto n = numbers(call, 1, {dim});
        return make_image(std::move(shapes(call, 1)[0]),
                          Tensor<2, dim>(dealii::unit_symmetric_tensor<dim>()),
                          point(n, 0));
      }

      std::unique_ptr<Shape<dim>>
      turn(const Call &call) const
      {
        const auto     n = numbers(call, 1, {dim == 2 ? 3 : 7});
        Tensor<2, dim> rotation;
        const double   angle = n[0] * dealii::numbers::PI / 180.;
        if constexpr (dim == 2)
          rotation =
            dealii::Physics::Transformations::Rotations::rotation_matrix_2d(
              angle);
        else
          {
            const Point<3> axis = point(n, 4);
            require(axis.norm() > 0.,
                    written(call),
                    "its axis must have a length: " + call.usage);
            rotation =
              dealii::Physics::Transformations::Rotations::rotation_matrix_3d(
                axis / axis.norm(), angle);
          }
        const Point<dim> about = point(n, 1);
        return make_image(std::move(shapes(call, 1)[0]),
                          rotation,
                          about - rotation * about);
      }

      std::unique_ptr<Shape<dim>>
      scale(const Call &call) const
      {
        auto n = numbers(call, 1, {1, dim});
        n.resize(dim, n[0]);
        Tensor<2, dim> factors;
        for (unsigned int d = 0; d < dim; ++d)
          {
            require(n[d] != 0., written(call), "no factor may be 0");
            factors[d][d] = n[d];
          }
        return make_image(std::move(shapes(call, 1)[0]),
                          factors,
                          Tensor<1, dim>());
      }

      const std::string               section;
      std::map<std::string, Function> functions;
    };
  } // namespace

  template <int dim>
  std::unique_ptr<Shape<dim>>
  read_shape(const std::string &text, const std::string &section)
  {
    return Reader<dim>(section).read(text);
  }

  template std::unique_ptr<Shape<2>>
  read_shape<2>(const std::string &, const std::string &);
  template std::unique_ptr<Shape<3>>
  read_shape<3>(const std::string &, const std::string &);
} // namespace emmy
