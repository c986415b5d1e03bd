#include <deal.II/lac/trilinos_precondition.h>

#include <emmy/base/exceptions.h>
#include <emmy/solve/block_ilu.h>
#include <emmy/solve/coarse_boxes.h>
#include <emmy/solve/preconditioner.h>

namespace emmy
{
  namespace
  {
    namespace TW = dealii::TrilinosWrappers;

    /** One of Trilinos', by deal.II. */
    class Wrapped : public Preconditioner
    {
    public:
      void
      vmult(Vector &z, const Vector &r) const override
      {
        preconditioner->vmult(z, r);
      }

    protected:
      std::unique_ptr<TW::PreconditionBase> preconditioner;
    };

    class Jacobi : public Wrapped
    {
    public:
      void
      make(const Matrix &matrix, const NodePlaces *) override
      {
        auto jacobi = std::make_unique<TW::PreconditionJacobi>();
        jacobi->initialize(matrix);
        preconditioner = std::move(jacobi);
      }
    };

    class Multigrid : public Wrapped
    {
    public:
      explicit Multigrid(const unsigned int n_components)
        : n_components(n_components)
      {}

      void
      make(const Matrix &matrix, const NodePlaces *) override
      {
        TW::PreconditionAMG::AdditionalData data;
        data.elliptic = false; // the tangent is not symmetric
        data.constant_modes.resize(n_components,
                                   std::vector<bool>(matrix.local_size(),
                                                     false));
        // all components of a node are on one rank
        for (unsigned int i = 0; i < matrix.local_size(); ++i)
          data.constant_modes[i % n_components][i] = true;
        auto multigrid = std::make_unique<TW::PreconditionAMG>();
        multigrid->initialize(matrix, data);
        preconditioner = std::move(multigrid);
      }

    private:
      const unsigned int n_components;
    };

    /** ILU(0) in blocks, after a coarse level where places are known. */
    template <int n>
    class Ilu : public Preconditioner
    {
    public:
      void
      make(const Matrix &matrix, const NodePlaces *places) override
      {
        ilu.make(matrix);
        is_coarse = places != nullptr;
        if (is_coarse)
          boxes.make(matrix, *places);
        rest.reinit(matrix.locally_owned_range_indices(),
                    matrix.get_mpi_communicator());
      }

      bool
      outlives_matrix() const override
      {
        return true;
      }

      void
      vmult(Vector &z, const Vector &r) const override
      {
        if (!is_coarse)
          return ilu.vmult(z, r);
        boxes.correct(r, z, rest);
        ilu.vmult_add(z, rest);
      }

    private:
      BlockIlu<n>    ilu;
      CoarseBoxes<n> boxes;
      bool           is_coarse = false;
      mutable Vector rest;
    };
  } // namespace

  std::unique_ptr<Preconditioner>
  make_preconditioner(const std::string &name, const unsigned int n_components)
  {
    if (name == "Jacobi")
      return std::make_unique<Jacobi>();
    if (name == "ML")
      return std::make_unique<Multigrid>(n_components);
    AssertThrow(name == "ILU", dealii::ExcMessage("no preconditioner " + name));
    if (n_components == 2)
      return std::make_unique<Ilu<2>>();
    return std::make_unique<Ilu<3>>();
  }
} // namespace emmy
