// The condition estimate against closed forms and a singular value
// decomposition; what is found where particles of a block enter a new
// cell, with and without ghost stabilisation; that a step reports it if asked,
// and does the same as if not asked. On any number of ranks.

#include <deal.II/lac/lapack_full_matrix.h>

#include <deal.II/lac/trilinos_sparsity_pattern.h>
#include <emmy/effects/ghost_stabilisation.h>
#include <emmy/material/hencky.h>

#include <emmy/step/small_cuts.h>

#include "../check.h"
#include "../scene.h"

using namespace emmy;

namespace
{
  /** A matrix whose rows are dealt out to all ranks, with its constraints. */
  struct Example
  {
    dealii::IndexSet                  rows;
    Matrix                            matrix;
    dealii::AffineConstraints<double> constraints;
    Vector                            start;

    explicit Example(const dealii::FullMatrix<double> &entries)
      : rows(dealii::Utilities::create_evenly_distributed_partitioning(
          dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD),
          dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD),
          entries.m()))
    {
      dealii::TrilinosWrappers::SparsityPattern pattern(rows, MPI_COMM_WORLD);
      for (const auto i : rows)
        for (unsigned int j = 0; j < entries.n(); ++j)
          pattern.add(i, j);
      pattern.compress();
      matrix.reinit(pattern);
      for (const auto i : rows)
        for (unsigned int j = 0; j < entries.n(); ++j)
          matrix.set(i, j, entries(i, j));
      matrix.compress(dealii::VectorOperation::insert);
      start.reinit(rows, MPI_COMM_WORLD);
      for (const auto i : rows)
        start(i) = std::sin(3. * i + 1.);
    }

    ConditionEstimate
    estimate()
    {
      constraints.close();
      return condition_estimate(matrix, constraints, start);
    }
  };

  /** The index of the entry of size one, on all ranks. */
  unsigned int
  largest_entry(const Vector &vector)
  {
    unsigned int result = 0;
    for (const auto i : vector.locally_owned_elements())
      if (std::abs(vector(i)) > 0.999)
        result = i;
    return dealii::Utilities::MPI::max(result, MPI_COMM_WORLD);
  }

  /**
   * Blocks (1 c; 0 1), scaled with powers of ten that the estimate must not
   * see. Their singular values are (sqrt(c^2 + 4) +- c)/2, and the unknown
   * that the largest c hides is the first of its block.
   */
  void
  check_shears()
  {
    const std::vector<double>  shears{0.1, 2., 1e5, -30., 0.};
    dealii::FullMatrix<double> entries(10, 10);
    const auto                 scale = [](const unsigned int i) {
      return std::pow(10., static_cast<int>(3 * i % 7) - 3);
    };
    for (unsigned int block = 0; block < shears.size(); ++block)
      {
        const unsigned int i  = 2 * block;
        entries(i, i)         = scale(i) * scale(i);
        entries(i + 1, i + 1) = -scale(i + 1) * scale(i + 1);
        entries(i, i + 1)     = shears[block] * scale(i) * scale(i + 1);
      }
    const auto condition = [](const double c) {
      return std::pow((std::sqrt(c * c + 4.) + c) / 2., 2);
    };
    Example    example(entries);
    const auto estimate = example.estimate();
    test::check_close(estimate.condition() / condition(1e5),
                      1.,
                      1e-5,
                      "condition of a shear of 1e5");
    test::check_close(estimate.largest * estimate.smallest,
                      1.,
                      1e-5,
                      "a shear's singular values are inverse");
    test::check(largest_entry(estimate.weakest) == 4, "the weakest unknown");

    // a constrained unknown is not there
    example.constraints.add_line(4);
    const auto less = example.estimate();
    test::check_close(less.condition() / condition(30.),
                      1.,
                      1e-5,
                      "condition without the largest shear");
    for (const auto i : less.weakest.locally_owned_elements())
      test::check(i != 4 || less.weakest(i) == 0., "nor is it weak");

    // on transposing, the other unknown of the block is hidden
    dealii::FullMatrix<double> transposed(10, 10);
    transposed.copy_transposed(entries);
    const auto other = Example(transposed).estimate();
    test::check_close(other.condition() / condition(1e5),
                      1.,
                      1e-5,
                      "condition of the transposed matrix");
  }

  /** 1/(i + j + 1), scaled to a unit diagonal. */
  dealii::FullMatrix<double>
  hilbert(const unsigned int n)
  {
    dealii::FullMatrix<double> entries(n, n);
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < n; ++j)
        entries(i, j) = std::sqrt((2. * i + 1.) * (2. * j + 1.)) / (i + j + 1.);
    return entries;
  }

  void
  check_hilbert()
  {
    for (const unsigned int n : {1, 3, 6, 9})
      {
        dealii::LAPACKFullMatrix<double> copy(n, n);
        copy = hilbert(n);
        copy.compute_svd();
        const double exact =
          copy.singular_value(0) / copy.singular_value(n - 1);
        const double found = Example(hilbert(n)).estimate().condition();
        std::cout << "Hilbert " << n << ": condition " << found << ", exact "
                  << exact << '\n';
        test::check_close(found / exact,
                          1.,
                          1e-5 + 1e-15 * exact,
                          "condition of a scaled Hilbert matrix");
      }
  }

  void
  check_singular()
  {
    // rank one, as the mass of a single particle
    dealii::FullMatrix<double> entries(4, 4);
    for (unsigned int i = 0; i < 4; ++i)
      for (unsigned int j = 0; j < 4; ++j)
        entries(i, j) = (1. + i) * (1. + j);
    test::check(Example(entries).estimate().is_singular(), "rank one");
    // an unknown that nothing reaches
    dealii::FullMatrix<double> missing = hilbert(4);
    for (unsigned int i = 0; i < 4; ++i)
      missing(2, i) = missing(i, 2) = 0.;
    const auto estimate = Example(missing).estimate();
    test::check(estimate.is_singular(), "a row of zeros");
    test::check(largest_entry(estimate.weakest) == 2, "which row");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    missing(0, 1)    = nan;
    test::check(std::isnan(Example(missing).estimate().condition()),
                "no estimate of what is no number");
  }

  /**
   * A block of 3 x 3 cells with 2 x 2 particles each, and more in the cell
   * that follows its middle row, at these distances from the cell's lower
   * corner, in cell sizes. They are the last particles, from 36 on.
   */
  struct Scouts
  {
    Diagnosis<2> mass;

    Scouts(const std::vector<dealii::Point<2>> &scouts,
           const double                         ghost_mass   = 0.,
           const MPI_Comm                       communicator = MPI_COMM_WORLD)
    {
      dealii::ParameterAcceptor::clear();
      GridParameters<2> parameters;
      parameters.cells        = {8, 8};
      parameters.upper_corner = dealii::Point<2>(4., 8.);
      const BackgroundGrid<2>     grid(parameters, communicator);
      const BoundaryParameters    boundary;
      const BoundaryConditions<2> walls(boundary, grid);

      FieldLayout                           layout = basic_fields(2);
      const LinearShapeFunctions<2>         shape_functions(layout["body"]);
      dealii::Particles::ParticleHandler<2> particles(grid.triangulation(),
                                                      grid.mapping(),
                                                      layout.n_components());
      std::vector<double>                   values = layout.initial_values();
      values[layout["mass"]]                       = 2.5;
      unsigned int id                              = 0;
      const auto   insert = [&](const std::array<unsigned int, 2> &index,
                              const dealii::Point<2>            &reference) {
        const auto cell = grid.cell_at(index);
        if (cell != grid.triangulation().end() && cell->is_locally_owned())
          {
            dealii::Point<2> x = cell->vertex(0);
            for (unsigned int d = 0; d < 2; ++d)
              x[d] += reference[d] * grid.cell_size()[d];
            particles.insert_particle(
              x,
              reference,
              id,
              cell,
              dealii::ArrayView<const double>(values.data(), values.size()));
          }
        ++id;
      };
      for (unsigned int i = 0; i < 9; ++i)
        for (unsigned int p = 0; p < 4; ++p)
          insert({{2 + i % 3, 2 + i / 3}},
                 dealii::Point<2>(p % 2 ? 0.75 : 0.25, p / 2 ? 0.75 : 0.25));
      for (const auto &scout : scouts)
        insert({{5, 3}}, scout);
      particles.update_cached_numbers();

      ElasticConstants constants;
      constants.density       = 20.; // of 2 x 2 particles in a cell
      constants.young_modulus = 3.;
      constants.poisson_ratio = 0.;
      const Hencky<2>       material(constants.completed("test"));
      GhostStabilisation<2> ghosts(GhostFaces<2>(ghost_mass, 0., {&material}));
      const PointMapping    mapping;
      ParticlesToGrid<2>    particles_to_grid(grid, walls, layout, mapping);
      const auto   stencils = shape_functions.evaluate(particles, grid);
      const auto   points   = gather(stencils, layout);
      Couplings<2> couplings;
      if (ghost_mass > 0.)
        {
          ghosts.couple(stencils, grid, walls, couplings);
          couplings.hand_out_mass = [&](const ActiveGrid<2> &active,
                                        const MassReceiver  &receive) {
            ghosts.hand_out(active, receive);
          };
        }
      const auto &start = particles_to_grid(stencils, points, couplings);
      mass =
        diagnose(examined_mass(start), stencils, points, layout, *start.active);
    }
  };

  /** Two particles, a distance apart along the face, so deep in the cell. */
  std::vector<dealii::Point<2>>
  pair(const double distance, const double depth)
  {
    return {dealii::Point<2>(depth, 0.5 - distance / 2.),
            dealii::Point<2>(depth, 0.5 + distance / 2.)};
  }

  void
  check_scouts()
  {
    const bool is_first =
      dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
    double before = 0.;
    for (const double distance : {1e-1, 1e-2, 1e-3, 1e-4})
      {
        const Scouts       two(pair(distance, 0.1));
        const Scouts       stabilised(pair(distance, 0.1), 0.25);
        const Diagnosis<2> found = two.mass;
        if (is_first)
          std::cout << "pair " << distance << " apart: condition "
                    << found.condition << ", with ghosts "
                    << stabilised.mass.condition << '\n';
        // the two new nodes feel their difference with its square
        if (distance < 1e-2)
          test::check_close(found.condition / before,
                            100.,
                            2.,
                            "condition grows with 1/distance^2");
        before = found.condition;
        test::check(stabilised.mass.condition < 20.,
                    "ghost stabilisation bounds the condition");

        // the new nodes are at x = 3, y = 3 and 4
        test::check(!found.is_singular, "a pair is not singular");
        test::check(found.nodes.size() == 2, "two weak nodes");
        for (const WeakNode<2> &node : found.nodes)
          {
            test::check_close(node.position[0], 3., 1e-12, "weak node, x");
            test::check_close(node.position[1], 3.5, 0.5 + 1e-12, "and y");
            test::check(node.n_particles == 2 && node.feeders.size() == 2 &&
                          node.feeders[0].id + node.feeders[1].id == 36 + 37,
                        "the pair reaches it, and nobody else");
            test::check(node.cells.size() == 1, "it has one active cell");
            test::check_close(node.cells[0].distance(
                                dealii::Point<2>(2.75, 3.5)),
                              0.,
                              1e-12,
                              "that of the pair");
          }
      }

    // what a node's share alone does, the scaling takes away
    const double deep    = Scouts(pair(0.5, 0.1)).mass.condition,
                 shallow = Scouts(pair(0.5, 1e-8)).mass.condition,
                 least   = Scouts(pair(0.5, 1e-12)).mass.condition;
    if (is_first)
      std::cout << "pair 0.1, 1e-8, 1e-12 deep: condition " << deep << ", "
                << shallow << ", " << least << '\n';
    test::check(least < 3. * deep, "a shallow pair is harmless");
    test::check_close(least / shallow, 1., 1e-5, "as shallow as may be");
  }

  void
  check_alone()
  {
    const Scouts one({dealii::Point<2>(0.3, 0.4)});
    test::check(one.mass.is_singular, "one particle feeds two new nodes");
    test::check(one.mass.condition <= 1e16, "a finite number for the ledger");
    const std::string text = one.mass.text("mass matrix");
    for (const char *words :
         {"the scaled mass matrix has the condition number",
          "singular to round-off; weakest at node (3, ",
          "m of the active cell around (2.75, 3.5)",
          "1 particle reaches it: id 36 at (2.65, 3.4) with S = 0.1"})
      test::check(text.find(words) != std::string::npos,
                  "the text lacks <" + std::string(words) + ">: " + text);
    test::check(!Scouts({dealii::Point<2>(0.3, 0.4)}, 0.25).mass.is_singular,
                "ghost stabilisation holds it");

    // the same on all ranks, and as on one
    const Scouts two(pair(1e-3, 0.1));
    const Scouts alone(pair(1e-3, 0.1), 0., MPI_COMM_SELF);
    test::check_close(two.mass.condition / alone.mass.condition,
                      1.,
                      1e-5,
                      "condition on one rank");
    test::check(two.mass.text("mass matrix") == alone.mass.text("mass matrix"),
                "on all ranks <" + two.mass.text("mass matrix") +
                  ">, on one <" + alone.mass.text("mass matrix") + ">");
  }

  /** A block as soft as gas, that flies a quarter of a cell and a bit in a
   * step.
   */
  std::string
  flying_block(const std::string &diagnosis)
  {
    return "set Dimension = 2\n"
           "subsection Method\nset Shape functions = linear\n"
           "set Starved nodes = free\nend\n"
           "subsection Grid\nset Upper corner = 8, 8\nset Cells = 8, 8\nend\n"
           "subsection Materials\nset Names = m\nsubsection m\n"
           "set Model = Hencky\nset Density = 5\n"
           "set Young's modulus = 1e-30\nset Poisson's ratio = 0.3\nend\nend\n"
           "subsection Bodies\nset Names = block\nsubsection block\n"
           "set Shape = box\nset Material = m\nset Points per direction = 2\n"
           "set Initial velocity = 0.25000000001; 0\n"
           "subsection box\nset Lower corner = 1, 2\n"
           "set Upper corner = 4, 5\nend\nend\nend\n"
           "subsection Time\nset End time = 9\nset Step rule = fixed\n"
           "set Step size = 1\nend\n" +
           diagnosis;
  }

  void
  check_step()
  {
    const SceneParameters<2> plain_parameters(
      ParameterFile::from_text(flying_block(""), "block"));
    test::RunningScene<2> plain(plain_parameters);
    plain.advance(2);
    test::check(!plain.scene.stepper->diagnosis(), "no diagnosis unless asked");

    const SceneParameters<2> parameters(ParameterFile::from_text(
      flying_block("subsection Diagnosis\nset Small cuts = true\n"
                   "set Report above = 50\nend\n"),
      "block"));
    test::RunningScene<2>    asked(parameters);
    asked.ledger.add(asked.scene.advance());
    const StepReport report = asked.scene.advance();
    asked.ledger.add(report);
    test::check(report.findings.size() == 2, "two findings");

    // the same step, and two columns more
    auto names = plain.ledger.columns();
    for (const std::string &name : names)
      test::check(plain.column(name) == asked.column(name),
                  name + " is the same if asked");
    names.insert(names.end(), {"mass_condition", "jacobian_condition"});
    test::check(asked.ledger.columns() == names, "two columns more");
    test::check(asked.column("mass_condition")[0] == 0.,
                "no condition before the first step");

    // Nothing resists but the mass, and the new nodes have S = 1e-11, where
    // the damping of 1e-13 that Newton solves with would show.
    std::cout << "condition of the mass " << asked.ledger["mass_condition"]
              << ", of the Jacobian " << asked.ledger["jacobian_condition"]
              << '\n';
    test::check(asked.ledger["mass_condition"] > 80., "a sliver");
    test::check_close(asked.ledger["jacobian_condition"] /
                        asked.ledger["mass_condition"],
                      1.,
                      1e-4,
                      "without stiffness the Jacobian is the mass");

    const StepDiagnosis<2> *found   = asked.scene.stepper->diagnosis();
    const auto             &active  = *asked.scene.stepper->grid_start().active;
    double                  largest = 0.;
    for (const double weakness : found->mass.weakness)
      largest = std::max(largest, weakness);
    test::check(found->mass.weakness.size() == active.n_local_nodes(),
                "a weakness for each node");
    test::check_close(dealii::Utilities::MPI::max(largest, MPI_COMM_WORLD),
                      1.,
                      1e-15,
                      "the weakest has 1");
    test::check_close(found->mass.nodes[0].position[0],
                      5.,
                      1e-12,
                      "it is in the new column");
  }
} // namespace

int
main(int argc, char *argv[])
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check_shears();
  check_hilbert();
  check_singular();
  check_scouts();
  check_alone();
  check_step();
  return test::report();
}
