#include <deal.II/base/utilities.h>

#include <emmy/base/exceptions.h>
#include <emmy/effects/mean_dilatation.h>
#include <emmy/effects/moving_places.h>
#include <emmy/run/card_line.h>
#include <emmy/run/scene_memory.h>
#include <emmy/system/nodal_matrix.h>

#ifdef __GLIBC__
#  include <malloc.h>
#endif

#include <algorithm>
#include <cmath>

namespace emmy
{
  namespace
  {
    /** Code and constants that the first step touches: of libraries. */
    constexpr double first_touched = 4e6;

    /**
     * What free pieces between arrays take, as a part of these: the heap gives
     * nothing back before the program ends (a library asks for that), and where
     * places move each iteration has arrays of other sizes. Measured with
     * heaptrack, see doc/performance.md.
     */
    constexpr double holes_at_start = 0.08, holes_in_middle = 0.2;

    /** Vectors of GMRES, as many as its iterations. */
    constexpr double krylov_vectors = 20.;

    /** What stands together, B. */
    struct Stage
    {
      double points = 0., matrices = 0., solver = 0., vectors = 0., output = 0.;

      double
      sum() const
      {
        return points + matrices + solver + vectors + output;
      }
    };

    Stage
    larger(const Stage &a, const Stage &b)
    {
      return a.sum() > b.sum() ? a : b;
    }

    /** What the lengths of arrays depend on; of this rank. */
    template <int dim>
    struct Counts
    {
      Counts(const Stencils<dim> &stencils, const ActiveGrid<dim> &active)
        : points(stencils.particles.size())
        , entries(stencils.values.size())
        , groups(stencils.groups.size())
        , node_ids(stencils.node_ids.size())
        , nodes(active.n_local_nodes())
        , pairs(active.graph().n_pairs())
      {}

      double points, entries, groups, node_ids, nodes, pairs;
    };

    /** Stencils of the particles as they are, boxes moved by a part of a cell.
     */
    template <int dim>
    Stencils<dim>
    usual_stencils(const Scene<dim> &scene)
    {
      constexpr double part = 0.1;
      Places<dim>      places =
        scene.shape_functions->places(scene.particles, scene.grid);
      if (places.half_lengths.empty() || scene.explicit_force)
        return scene.shape_functions->evaluate(places, scene.grid);
      for (std::size_t i = 0; i < places.size(); ++i)
        {
          dealii::Point<dim> &x = places.positions[i];
          x += part * scene.grid.size_of(places.cells[i]);
          x               = scene.grid.clamped(x);
          places.cells[i] = scene.grid.key_of(x);
        }
      try
        {
          return scene.shape_functions->evaluate(places, scene.grid);
        }
      catch (const ExcRun &) // of all ranks
        {
          return scene.shape_functions->evaluate(scene.particles, scene.grid);
        }
    }

    /**
     * Bytes of what stands together in a step, each array by its length: those
     * of one value of dim unknowns, of a pair of nodes and so on.
     */
    template <int dim>
    class Sizes
    {
    public:
      Sizes(const Scene<dim>           &scene,
            const SceneParameters<dim> &parameters,
            const Counts<dim>          &n)
        : scene(scene)
        , parameters(parameters)
        , n(n)
      {}

      /** Weights, and who reaches whom. */
      double
      stencils() const
      {
        using Group = typename Stencils<dim>::Group;
        return sizeof(double) * (1 + dim) * n.entries +
               sizeof(Group) * n.groups + sizeof(Id) * n.node_ids +
               (sizeof(typename Stencils<dim>::ParticleIterator) +
                sizeof(std::size_t)) *
                 n.points;
      }

      /** Positions and fields of all particles, once. */
      double
      states() const
      {
        return sizeof(double) * (dim + scene.layout.n_components()) * n.points;
      }

      /** Where they are. */
      double
      places() const
      {
        return (sizeof(typename Stencils<dim>::ParticleIterator) +
                sizeof(unsigned int) + sizeof(CellKey<dim>) +
                sizeof(dealii::Point<dim>) *
                  (scene.layout.has("half_length") ? 2 : 1)) *
               n.points;
      }

      /** How they follow the nodes. */
      double
      responses() const
      {
        return sizeof(typename MovingPlaces<dim>::Response) * n.points;
      }

      /** What averages over cells keep of each particle. */
      double
      averages_of_cells() const
      {
        if (parameters.locking_materials.empty() || scene.explicit_force)
          return 0.;
        return (sizeof(CellPoint<dim>) + sizeof(CellLink<dim>) +
                sizeof(dealii::Tensor<2, dim>) + sizeof(double) +
                2 * sizeof(std::size_t) + sizeof(unsigned int)) *
                 n.points +
               (sizeof(typename CellPools<dim>::Pool) +
                sizeof(Id) * n.entries / std::max(1., n.points)) *
                 n.points / (1 << dim);
      }

      /** Nodes, which of them meet, and some 10 bytes a pair for where those
       * of a neighbourhood stand. */
      double
      graph() const
      {
        return (2 * sizeof(unsigned int) + sizeof(int) * dim * dim + 10) *
                 n.pairs +
               (2 * sizeof(Id)) * n.node_ids + 70. * dim * n.nodes;
      }

      /** The mass, a number for each pair. */
      double
      mass() const
      {
        return sizeof(double) * n.pairs;
      }

      /** A matrix of all unknowns. */
      double
      matrix() const
      {
        return sizeof(double) * dim * dim * n.pairs + 24. * dim * n.nodes;
      }

      /** ILU, the coarse level, and columns for products. */
      double
      preconditioner() const
      {
        return (sizeof(float) * dim * dim + 2 * sizeof(unsigned int)) *
                 n.pairs +
               40. * dim * n.nodes + coarse_level();
      }

      /** A file of the particles: numbers, and its text, which is copied. */
      double
      output() const
      {
        unsigned int n_numbers = 1; // the id
        for (const ParticleField<dim> &field : scene.written_fields)
          n_numbers += field.description.n_components;
        // lines of a cache, and a head
        const double numbers =
          64. * std::ceil(sizeof(float) * n_numbers / 64.) + 16.;
        // compressed, and then three bytes as four letters
        const double text =
          0.7 * 4. / 3. * sizeof(float) * (dim + n_numbers) + 16.;
        return (sizeof(dealii::DataOutBase::Patch<0, dim>) + numbers +
                sizeof(std::int64_t) + 4. * text) *
               n.points;
      }

      /** LU of a matrix. */
      double
      factors() const
      {
        const double unknowns = dim * n.nodes;
        return dim == 2 ? 12. * 8. * unknowns * std::log2(1. + unknowns)
                        : 12. * 10. * std::pow(unknowns, 4. / 3.);
      }

      /** Vectors of unknowns. */
      double
      vectors(const double how_many) const
      {
        return sizeof(double) * dim * how_many * n.nodes;
      }

    private:
      using Id = dealii::types::global_dof_index;

      double
      coarse_level() const
      {
        constexpr double n_modes = dim * (dim + 1) / 2;
        // a box has an edge of six cells, and a node of its sides two
        const double boxes = dealii::Utilities::fixed_power<dim>(1. + 2. / 6.);
        return sizeof(double) * n_modes * dim * (1. + boxes) * n.nodes;
      }

      const Scene<dim>           &scene;
      const SceneParameters<dim> &parameters;
      const Counts<dim>          &n;
    };

    /** What a step adds where it takes most, and what is written behind it. */
    template <int dim>
    Stage
    largest_stage(const Sizes<dim>           &size,
                  const Scene<dim>           &scene,
                  const SceneParameters<dim> &parameters,
                  const unsigned int          n_matrices)
    {
      Stage step, output;
      step.points =
        size.stencils() + 2. * size.states() + size.averages_of_cells();
      step.vectors = size.vectors(10.);
      if (!scene.explicit_force)
        {
          step.matrices = n_matrices * size.matrix();
          step.solver   = output.solver =
            parameters.solver.linear_solver == "direct"
                ? size.matrix() + size.factors() // of a copy
                : size.preconditioner();
          Stage in_solver   = step;
          in_solver.vectors = size.vectors(15. + krylov_vectors);
          // where nodes change the solver has those of before until it begins
          step.matrices += size.graph();
          if (!scene.middle)
            step = larger(step, in_solver);
        }
      if (scene.middle) // places of now, of before, and of the start
        step.points += 3. * size.places() + size.responses();
      if (parameters.output.frames > 0 && parameters.output.particle_files)
        output.output = size.output();
      return larger(step, output);
    }

    /** Of this process, B. */
    double
    resident_memory()
    {
#ifdef __GLIBC__
      malloc_trim(0); // what is free here, the step will use
#endif
      dealii::Utilities::System::MemoryStats memory; // in kB
      dealii::Utilities::System::get_memory_stats(memory);
      return 1024. * memory.VmRSS;
    }

    /** What more than now there is, of this rank, B. */
    struct Added
    {
      Stage  stage;      ///< where most stands together
      double nodes = 0.; ///< which of them meet, and their mass
      double holes = 0.; ///< free pieces
    };

    /** Collective. */
    template <int dim>
    Added
    added_by_steps(const Scene<dim>           &scene,
                   const SceneParameters<dim> &parameters,
                   const unsigned int          n_matrices)
    {
      const Stencils<dim>    stencils = usual_stencils(scene);
      const PointArrays<dim> points   = gather(stencils, scene.layout);
      scene.balance.classify(stencils, points, scene.grid, nullptr);
      const ActiveGrid<dim> active(
        stencils,
        scene.balance.couplings(
          stencils, scene.grid, scene.boundary_conditions, nullptr),
        scene.grid,
        scene.boundary_conditions,
        scene.explicit_force ? ActiveGrid<dim>::Matrices::none
                             : ActiveGrid<dim>::Matrices::wanted);
      const ActiveGrid<dim> &active_now = *scene.stepper->grid_start().active;
      const Counts<dim>      counts(stencils, active);
      Counts<dim>            counts_now = counts;
      counts_now.nodes                  = active_now.n_local_nodes();
      counts_now.pairs                  = active_now.graph().n_pairs();
      const Sizes<dim> size(scene, parameters, counts),
        now(scene, parameters, counts_now);
      Added result;
      result.stage = largest_stage(size, scene, parameters, n_matrices);
      result.nodes = size.graph() + size.mass() - now.graph() - now.mass();
      result.holes = (scene.middle ? holes_in_middle : holes_at_start) *
                     (result.stage.sum() + result.nodes);
      return result;
    }
  } // namespace

  template <int dim>
  SceneMemory
  predict_memory(const Scene<dim>           &scene,
                 const SceneParameters<dim> &parameters,
                 const unsigned int          n_matrices)
  {
    const Added    added        = added_by_steps(scene, parameters, n_matrices);
    const MPI_Comm communicator = scene.grid.communicator();
    SceneMemory    result;
    double         of_rank = 0.;
    const auto     add     = [&](const std::string &name, const double bytes) {
      result.parts.push_back(
        {name, dealii::Utilities::MPI::sum(bytes, communicator)});
      of_rank += bytes;
    };
    add("program, grid and particles", resident_memory() + first_touched);
    add("points", added.stage.points);
    add("matrices", added.stage.matrices);
    add("linear solver", added.stage.solver);
    add("vectors", added.stage.vectors);
    add("nodes", added.nodes);
    add("output", added.stage.output);
    add("holes", added.holes);
    result.total   = dealii::Utilities::MPI::sum(of_rank, communicator);
    result.largest = dealii::Utilities::MPI::max(of_rank, communicator);
    std::stable_sort(result.parts.begin(),
                     result.parts.end(),
                     [](const auto &a, const auto &b) {
                       return a.bytes > b.bytes;
                     });
    return result;
  }

  void
  print_memory(const SceneMemory &memory, std::ostream &out)
  {
    const auto megabytes = [](const double bytes) {
      return std::to_string(std::llround(bytes / 1e6));
    };
    card_line(out, "memory of a run")
      << megabytes(memory.total) << " MB at its peak";
    if (memory.largest < 0.999 * memory.total)
      out << ", on all ranks, " << megabytes(memory.largest)
          << " on the one with most";
    const char *separator = ": ";
    for (const auto &[name, bytes] : memory.parts)
      if (bytes >= 0.01 * memory.total)
        {
          out << separator << name << ' ' << megabytes(bytes);
          separator = ", ";
        }
    out << '\n';
  }

  template SceneMemory
  predict_memory<2>(const Scene<2> &,
                    const SceneParameters<2> &,
                    const unsigned int);
  template SceneMemory
  predict_memory<3>(const Scene<3> &,
                    const SceneParameters<3> &,
                    const unsigned int);
} // namespace emmy
