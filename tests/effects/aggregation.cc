// Starved nodes and their roots: who follows whom in a block, in a sliver
// beside it, in a lone particle, in a strip and across a gap between two
// bodies; in random clouds of few points the choice does not depend on the
// ranks, followers reproduce affine fields, and forces that are handed over do
// the same work.

#include <map>

#include "../check.h"
#include "../step/cloud.h"

using namespace emmy;

namespace
{
  /** A node, counted in cells, and the cells of its roots. */
  template <int dim>
  using Choice = std::map<CellKey<dim>, std::vector<CellKey<dim>>>;

  /** Points at the centres of a subdivision of each cell, as bodies fill. */
  template <int dim>
  struct Filling
  {
    GridParameters<dim>                     parameters;
    std::unique_ptr<BackgroundGrid<dim>>    grid;
    FieldLayout                             layout = basic_fields(dim);
    dealii::Particles::ParticleHandler<dim> particles;
    unsigned int                            n_points = 0;

    /** A grid of unit cells. */
    explicit Filling(const std::vector<unsigned int> &cells)
    {
      dealii::ParameterAcceptor::clear();
      parameters.cells = cells;
      for (unsigned int d = 0; d < dim; ++d)
        parameters.upper_corner[d] = cells[d];
      grid = std::make_unique<BackgroundGrid<dim>>(parameters, MPI_COMM_WORLD);
      particles.initialize(grid->triangulation(),
                           grid->mapping(),
                           layout.n_components());
    }

    /** Fill what of the grid's cells is inside a box, n points a direction. */
    void
    fill(const dealii::Point<dim> &lower,
         const dealii::Point<dim> &upper,
         const unsigned int        n,
         const unsigned int        body = 0)
    {
      std::vector<double> values         = layout.initial_values();
      values[layout["body"]]             = body;
      values[layout["mass"]]             = 7. / std::pow(n, dim);
      values[layout["reference_volume"]] = 1. / std::pow(n, dim);
      for (const auto &cell : grid->triangulation().active_cell_iterators())
        if (cell->is_locally_owned())
          for (unsigned int i = 0; i < std::pow(n, dim); ++i)
            {
              dealii::Point<dim> unit;
              for (unsigned int d = 0, rest = i; d < dim; ++d, rest /= n)
                unit[d] = (rest % n + 0.5) / n;
              const dealii::Point<dim> x         = cell->vertex(0) + unit;
              bool                     is_inside = true;
              for (unsigned int d = 0; d < dim; ++d)
                is_inside = is_inside && lower[d] < x[d] && x[d] < upper[d];
              if (is_inside)
                particles.insert_particle(x,
                                          unit,
                                          n_points++,
                                          cell,
                                          dealii::ArrayView<const double>(
                                            values.data(), values.size()));
            }
      particles.update_cached_numbers();
    }
  };

  template <int dim>
  CellKey<dim>
  lattice_of(const dealii::Point<dim> &x, const BackgroundGrid<dim> &grid)
  {
    CellKey<dim> result;
    for (unsigned int d = 0; d < dim; ++d)
      result[d] =
        std::lround((x[d] - grid.lower_corner()[d]) / grid.cell_size()[d]);
    return result;
  }

  template <int dim>
  Aggregates<dim>
  aggregate(const Filling<dim> &filling, const double threshold)
  {
    const auto stencils = LinearShapeFunctions<dim>(filling.layout["body"])
                            .evaluate(filling.particles, *filling.grid);
    const auto             points = gather(stencils, filling.layout);
    const Aggregation<dim> aggregation(threshold,
                                       filling.layout["mass"],
                                       filling.layout["reference_volume"]);
    return aggregation.find(aggregation.classify(stencils,
                                                 points,
                                                 *filling.grid),
                            stencils,
                            *filling.grid);
  }

  /** The choices of all ranks. */
  template <int dim>
  Choice<dim>
  choices(const Aggregates<dim> &aggregates, const BackgroundGrid<dim> &grid)
  {
    std::vector<std::array<unsigned int, 2 * dim>> mine;
    for (const Follower<dim> &follower : aggregates.followers)
      if (grid.nodes()->in_local_range(follower.node_id))
        for (const Root<dim> &root : follower.roots)
          {
            const auto node =
              lattice_of<dim>(grid.node_position(follower.node_id), grid);
            mine.emplace_back();
            std::copy(node.begin(), node.end(), mine.back().begin());
            std::copy(root.cell.begin(),
                      root.cell.end(),
                      mine.back().begin() + dim);
          }
    Choice<dim> all;
    for (const auto &part :
         dealii::Utilities::MPI::all_gather(grid.communicator(), mine))
      for (const auto &entry : part)
        {
          CellKey<dim> node, root;
          std::copy_n(entry.begin(), dim, node.begin());
          std::copy_n(entry.begin() + dim, dim, root.begin());
          all[node].push_back(root);
        }
    return all;
  }

  /** A sliver grows by a cell while the classes of its start are held. */
  void
  check_held_classes()
  {
    using Point = dealii::Point<2>;
    Filling<2> before({8, 4}), after({8, 4});
    before.fill(Point(1, 1), Point(3.3, 3), 4);
    after.fill(Point(2, 1), Point(4.8, 3), 4);
    const Aggregation<2> aggregation(0.2,
                                     before.layout["mass"],
                                     before.layout["reference_volume"]);
    const auto           evaluate = [](const Filling<2> &filling) {
      return LinearShapeFunctions<2>(filling.layout["body"])
        .evaluate(filling.particles, *filling.grid);
    };
    const auto at_start = evaluate(before), later = evaluate(after);
    const auto held = aggregation.classify(at_start,
                                           gather(at_start, before.layout),
                                           *before.grid);
    // the grids are equal; classes belong to one
    const auto renewed = aggregation.find(held, later, *before.grid);
    test::check(renewed.n_followers == 6 && renewed.n_kept == 0,
                "nodes that are new starve: " + renewed.text());
    for (const auto &[node, roots] : choices(renewed, *before.grid))
      for (const CellKey<2> &root : roots)
        test::check(root[0] == 2u && node[0] >= 4,
                    "they follow roots that are still active");

    const auto now =
      aggregation.classify(later, gather(later, after.layout), *after.grid);
    test::check(class_changes(held, held, *before.grid) == 0,
                "the same classes: no change");
    test::check(class_changes(held, now, *before.grid) == 3,
                "the three nodes that the sliver has filled are fed now; the "
                "new and the left ones do not count");
  }

  /** What is not looked for again is what would be found. */
  void
  check_classes_of_before()
  {
    using Point = dealii::Point<2>;
    Filling<2>           body({12, 4});
    const Aggregation<2> aggregation(0.2,
                                     body.layout["mass"],
                                     body.layout["reference_volume"]);
    NodeClasses<2>       before;
    const auto           check_next = [&](const unsigned int n_kept,
                                const std::string &what) {
      const auto stencils = LinearShapeFunctions<2>(body.layout["body"])
                              .evaluate(body.particles, *body.grid);
      const auto points = gather(stencils, body.layout);
      const auto alone = aggregation.classify(stencils, points, *body.grid);
      before = aggregation.classify(stencils, points, *body.grid, before);
      test::check(before.same_nodes_as(alone) && alone.same_nodes_as(before) &&
                    before.active == alone.active && before.n_kept == n_kept,
                  what + ", as from nothing");
    };
    body.fill(Point(1, 1), Point(3.3, 3), 4);
    check_next(0, "a sliver");
    const auto sliver = before;
    check_next(0, "the sliver again");
    body.fill(Point(3.3, 1), Point(4, 3), 4);
    check_next(0, "a block");
    test::check(dealii::Utilities::MPI::max(before.same_nodes_as(sliver) ? 0
                                                                         : 1,
                                            MPI_COMM_WORLD) == 1,
                "the block has other classes");
    body.fill(Point(9, 3), Point(9.5, 3.5), 2);
    check_next(4, "with a lone particle");
    check_next(4, "with a lone particle again");
  }

  void
  check_known_cases()
  {
    using Point = dealii::Point<2>;
    {
      Filling<2> block({6, 4});
      block.fill(Point(1, 1), Point(4, 3), 2);
      const auto found = aggregate(block, 0.2);
      test::check(found.n_followers == 0 && found.n_kept == 0,
                  "full cells: no node starves, corners have a quarter");
      test::check(aggregate(block, 0.25).n_followers == 0,
                  "a node exactly at the threshold is fed");
      test::check(aggregate(block, 0.26).n_followers == 4,
                  "above a quarter the four corners follow");
    }
    {
      // a quarter of a cell's width more: the outer nodes have 1/32 or less
      Filling<2> sliver({6, 4});
      sliver.fill(Point(1, 1), Point(3.3, 3), 4);
      const auto found = aggregate(sliver, 0.2);
      const auto roots = choices(found, *sliver.grid);
      test::check(found.n_followers == 3 && found.n_kept == 0 &&
                    found.farthest_root == 1 && found.largest_weight == 2.,
                  "a sliver: " + found.text());
      using Cells = std::vector<CellKey<2>>;
      test::check(roots.count({{4, 2}}) &&
                    roots.at({{4, 1}}) == Cells{{{2, 1}}} &&
                    roots.at({{4, 3}}) == Cells{{{2, 2}}},
                  "a sliver follows the cells beside it");
      test::check(roots.at({{4, 2}}) == Cells({{{2, 1}}, {{2, 2}}}),
                  "roots that are equally near share");
      for (const auto &follower : found.followers)
        if (follower.roots.size() == 2)
          test::check(follower.masters.size() == 2 &&
                        follower.masters[0].weight == -1. &&
                        follower.masters[1].weight == 2.,
                      "both continue the same line");
    }
    {
      // half a cell at a side of the grid is as full as elsewhere
      Filling<2> side({6, 4});
      side.fill(Point(0, 0), Point(3, 4), 2);
      test::check(aggregate(side, 0.45).n_followers == 0,
                  "at a side of the grid full is half of h^dim");
    }
    {
      Filling<2> lone({6, 4});
      lone.fill(Point(1, 1), Point(4, 3), 2);
      lone.fill(Point(5, 3), Point(5.5, 3.5), 2);
      const auto found = aggregate(lone, 0.2);
      test::check(found.n_followers == 0 && found.n_kept == 4,
                  "a lone particle is its own root");
    }
    {
      // no cell has four fed nodes: those of both ends follow, all else is free
      Filling<2> strip({12, 4});
      strip.fill(Point(1, 1), Point(11, 1.25), 4);
      const auto found = aggregate(strip, 0.2);
      test::check(found.n_followers == 4 && found.n_kept == 9,
                  "a thin strip is not made rigid: " + found.text());
    }
    {
      // bodies that share a column of nodes: roots of both are equally near,
      // and share, whichever body has which mass, number or name
      Filling<2> gap({8, 4});
      gap.fill(Point(1, 1), Point(3.3, 3), 4, 0);
      gap.fill(Point(4.9, 1), Point(7, 3), 8, 1);
      const auto found = aggregate(gap, 0.2);
      const auto roots = choices(found, *gap.grid);
      test::check(roots.at({{4, 2}}) ==
                    std::vector<CellKey<2>>(
                      {{{2, 1}}, {{2, 2}}, {{5, 1}}, {{5, 2}}}),
                  "a node between two bodies follows both");
      for (const auto &follower : found.followers)
        if (follower.roots.size() == 4)
          test::check(follower.masters.size() == 4 &&
                        follower.masters[0].weight == -0.5 &&
                        follower.masters[1].weight == 1.,
                      "the mean of both lines");
    }
    {
      // an empty cell between them: they do not meet
      Filling<2> apart({8, 4});
      apart.fill(Point(1, 1), Point(3.3, 3), 4, 0);
      apart.fill(Point(5, 1), Point(7, 3), 8, 0);
      const auto roots = choices(aggregate(apart, 0.2), *apart.grid);
      test::check(!roots.empty(), "nodes at the gap starve");
      for (const auto &[node, of_node] : roots)
        for (const CellKey<2> &root : of_node)
          test::check(root[0] == 2u, "a node follows what its cells touch");
    }
    check_held_classes();
    check_classes_of_before();
  }

  /** One particle in a cell: nodes follow cells twice as large. */
  void
  check_coarse_particles()
  {
    using Point = dealii::Point<2>;
    using Cells = std::vector<CellKey<2>>;
    Filling<2> coarse({12, 12});
    coarse.fill(Point(1, 1), Point(6, 6), 1);
    const auto found = aggregate(coarse, 0.2);
    const auto roots = choices(found, *coarse.grid);
    test::check(found.n_followers == 36 - 9 && found.n_kept == 0 &&
                  found.farthest_root == 1 && found.largest_weight == 2.25,
                "corners of four families are free: " + found.text());
    test::check(roots.count({{2, 4}}) == 0 && roots.count({{6, 6}}) == 0,
                "corners follow nothing");
    test::check(roots.at({{1, 1}}) == Cells{{{2, 2}}} &&
                  roots.at({{3, 3}}) == Cells{{{2, 2}}} &&
                  roots.at({{1, 4}}) == Cells({{{2, 2}}, {{2, 4}}}),
                "all others follow the nearest, or the mean");
    for (const auto &follower : found.followers)
      if (coarse.grid->node_key(follower.node_id) == CellKey<2>{{3, 3}})
        for (const auto &master : follower.masters)
          test::check(master.weight == 0.25,
                      "in the middle of a family: the mean of its corners");

    coarse.fill(Point(6, 1), Point(9, 6), 2);
    const auto mixed = choices(aggregate(coarse, 0.2), *coarse.grid);
    test::check(mixed.count({{6, 3}}) == 0 && mixed.count({{8, 3}}) == 0 &&
                  mixed.at({{5, 3}}) == Cells{{{2, 2}}},
                "nodes that finer particles reach move on their own");

    Filling<2> strip({12, 12});
    strip.fill(Point(1, 1), Point(6, 2), 1);
    test::check(aggregate(strip, 0.2).n_followers == 0,
                "where no family is near nothing changes");
  }

  template <int dim>
  void
  check_cloud(const test::CloudOptions &options, const std::string &what)
  {
    // search on one rank, and on all
    const FieldLayout      layout = basic_fields(dim);
    const Aggregation<dim> aggregation(options.aggregation,
                                       layout["mass"],
                                       layout["reference_volume"]);
    const auto             search = [&](const test::Cloud<dim> &cloud) {
      const auto stencils =
        cloud.shape_functions->evaluate(cloud.particles, *cloud.grid);
      const auto points = gather(stencils, cloud.layout);
      return aggregation.find(aggregation.classify(stencils,
                                                   points,
                                                   *cloud.grid),
                              stencils,
                              *cloud.grid);
    };
    const test::Cloud<dim> alone(options, MPI_COMM_SELF), cloud(options);
    const auto             expected = search(alone), found = search(cloud);
    const auto             roots = choices(found, *cloud.grid);
    test::check(roots == choices(expected, *alone.grid) &&
                  roots.size() == found.n_followers &&
                  found.n_kept == expected.n_kept &&
                  found.largest_weight == expected.largest_weight,
                what + ": the same choice on one rank");
    test::check(found.n_followers > 0, what + ": nodes follow");

    // constraints that reach across ranks
    const auto stencils =
      cloud.shape_functions->evaluate(cloud.particles, *cloud.grid);
    StarvedNodes<dim> starved(aggregation);
    starved.classify(stencils, gather(stencils, cloud.layout), *cloud.grid);
    Couplings<dim> couplings;
    starved.couple(stencils,
                   *cloud.grid,
                   *cloud.boundary_conditions,
                   couplings);
    Couplings<dim> again_couplings;
    starved.classify(stencils, gather(stencils, cloud.layout), *cloud.grid);
    starved.couple(stencils,
                   *cloud.grid,
                   *cloud.boundary_conditions,
                   again_couplings);
    test::check(again_couplings.tied_nodes == couplings.tied_nodes,
                what + ": with the same classes the same nodes follow");
    const ActiveGrid<dim> active(stencils,
                                 couplings,
                                 *cloud.grid,
                                 *cloud.boundary_conditions);
    const Constraints    &constraints = active.constraints();
    Vector                affine = active.make_vector(), force = affine;
    auto                  value = affine.begin(), f = force.begin();
    for (unsigned int node = 0; node < active.n_owned_nodes(); ++node)
      for (unsigned int c = 0; c < dim; ++c, ++value, ++f)
        {
          *value = 0.3 + c;
          for (unsigned int d = 0; d < dim; ++d)
            *value += (1.2 * c - 0.7 * d) * active.position(node)[d];
          *f = std::sin(active.position(node).square() * (7. + c));
        }
    Vector again = affine;
    constraints.set_zero(again);
    constraints.expand(again);
    again -= affine;
    test::check_close(again.linfty_norm(),
                      0.,
                      1e-13 * affine.linfty_norm(),
                      what + ": an affine field follows itself");
    const double work = force * affine, scale = force.l1_norm();
    constraints.condense(force);
    test::check_close(force * affine,
                      work,
                      1e-13 * scale * affine.linfty_norm(),
                      what + ": forces that are handed over do the same work");
  }

  template <int dim>
  void
  check_clouds()
  {
    for (const bool gimp : {false, true})
      for (unsigned int seed = 1; seed <= 20; ++seed)
        {
          test::CloudOptions options;
          options.n_points    = (1 + seed % 4) * (dim == 2 ? 12 : 36);
          options.seed        = seed;
          options.gimp        = gimp;
          options.aggregation = 0.45;
          check_cloud<dim>(options,
                           std::to_string(dim) + "D, " +
                             (gimp ? "GIMP" : "MPM") + ", cloud " +
                             std::to_string(seed));
        }
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_known_cases();
  check_coarse_particles();
  check_clouds<2>();
  check_clouds<3>();
  return test::report();
}
