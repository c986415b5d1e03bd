#include <deal.II/base/mpi.h>

#include <emmy/base/unknown.h>
#include <emmy/system/foreign_rows.h>

#include <Epetra_CrsMatrix.h>

#include <map>

namespace emmy
{
  using dealii::types::global_dof_index;

  template <int dim>
  void
  ForeignRows<dim>::make(const std::vector<global_dof_index> &first_dofs,
                         const dealii::IndexSet              &owned_dofs,
                         const std::vector<std::size_t>      &first,
                         const std::vector<unsigned int>     &neighbours,
                         const MPI_Comm                       communicator)
  {
    this->communicator = communicator;
    n_owned            = owned_dofs.n_elements() / dim;
    if (dealii::Utilities::MPI::n_mpi_processes(communicator) == 1)
      return;

    dealii::IndexSet not_owned(owned_dofs.size());
    for (unsigned int node = n_owned; node < first_dofs.size(); ++node)
      not_owned.add_index(first_dofs[node]);
    const std::vector<unsigned int> owners =
      dealii::Utilities::MPI::compute_index_owner(owned_dofs,
                                                  not_owned,
                                                  communicator);
    // a row: its unknown, how many neighbours, and which
    std::map<unsigned int, std::vector<global_dof_index>> told;
    for (unsigned int node = n_owned; node < first_dofs.size(); ++node)
      {
        const unsigned int owner = owners[node - n_owned];
        const std::size_t  begin = first[node] - first[n_owned],
                          n      = first[node + 1] - first[node];
        offsets.push_back(begin);
        if (n == 0)
          continue;
        if (outgoing.empty() || outgoing.back().rank != owner)
          outgoing.push_back({owner, begin, 0});
        outgoing.back().n += n;
        told[owner].push_back(first_dofs[node]);
        told[owner].push_back(n);
        for (std::size_t k = first[node]; k < first[node + 1]; ++k)
          told[owner].push_back(first_dofs[neighbours[k]]);
      }
    offsets.push_back(first.back() - first[n_owned]);
    values.assign(dim * dim * offsets.back(), 0.);

    const global_dof_index first_owned =
      n_owned > 0 ? *owned_dofs.begin() : global_dof_index(0);
    std::size_t n_received = 0;
    for (const auto &[rank, rows] :
         dealii::Utilities::MPI::some_to_some(communicator, told))
      {
        incoming.push_back({rank, n_received, 0});
        for (std::size_t i = 0; i < rows.size(); i += 2 + rows[i + 1])
          {
            const auto columns = rows.begin() + i + 2;
            others.push_back(
              {static_cast<unsigned int>((rows[i] - first_owned) / dim),
               {columns, columns + rows[i + 1]},
               {}});
            incoming.back().n += rows[i + 1];
          }
        n_received += incoming.back().n;
      }
    received.resize(dim * dim * n_received);
  }

  template <int dim>
  void
  ForeignRows<dim>::hand_over(Matrix &matrix) const
  {
    constexpr int            tag = 1861; // no other message has it
    std::vector<MPI_Request> requests;
    for (const Message &message : incoming)
      {
        requests.emplace_back();
        MPI_Irecv(received.data() + dim * dim * message.first,
                  dim * dim * message.n,
                  MPI_DOUBLE,
                  message.rank,
                  tag,
                  communicator,
                  &requests.back());
      }
    for (const Message &message : outgoing)
      {
        requests.emplace_back();
        MPI_Isend(values.data() + dim * dim * message.first,
                  dim * dim * message.n,
                  MPI_DOUBLE,
                  message.rank,
                  tag,
                  communicator,
                  &requests.back());
      }
    AssertThrowMPI(
      MPI_Waitall(requests.size(), requests.data(), MPI_STATUSES_IGNORE));

    const double *value = received.data();
    for (const RowOfOthers &row : others)
      for (unsigned int c = 0; c < dim; ++c)
        {
          double *entries = matrix.trilinos_matrix()[unknown<dim>(row.node, c)];
          for (const unsigned int place : row.places)
            for (unsigned int d = 0; d < dim; ++d)
              entries[dim * place + d] += *value++;
        }
    std::fill(values.begin(), values.end(), 0.);
  }

  template class ForeignRows<2>;
  template class ForeignRows<3>;
} // namespace emmy
