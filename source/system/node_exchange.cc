#include <deal.II/base/mpi.h>

#include <emmy/system/node_exchange.h>

#include <map>

namespace emmy
{
  namespace
  {
    constexpr int tag = 1862; // no other message has it
  }

  NodeExchange::NodeExchange(const dealii::Utilities::MPI::Partitioner &nodes)
    : communicator(nodes.get_mpi_communicator())
  {
    std::map<unsigned int, Neighbour> by_rank;
    unsigned int                      first = 0;
    for (const auto &[rank, n] : nodes.ghost_targets())
      {
        by_rank[rank] = {rank, first, first + n, {}};
        first += n;
      }
    auto range = nodes.import_indices().begin();
    for (const auto &[rank, n] : nodes.import_targets())
      {
        Neighbour &neighbour = by_rank[rank];
        neighbour.rank       = rank;
        while (neighbour.own.size() < n)
          {
            for (unsigned int node = range->first; node < range->second; ++node)
              neighbour.own.push_back(node);
            ++range;
          }
      }
    for (auto &[rank, neighbour] : by_rank)
      {
        (void)rank;
        all.push_back(std::move(neighbour));
      }
  }

  void
  NodeExchange::exchange(const unsigned int n,
                         const bool         to_owners,
                         double            *others) const
  {
    requests.clear();
    const auto message = [&](const bool         is_sent,
                             double            *values,
                             const std::size_t  n_nodes,
                             const unsigned int rank) {
      if (n_nodes == 0)
        return;
      requests.emplace_back();
      if (is_sent)
        MPI_Isend(values,
                  n * n_nodes,
                  MPI_DOUBLE,
                  rank,
                  tag,
                  communicator,
                  &requests.back());
      else
        MPI_Irecv(values,
                  n * n_nodes,
                  MPI_DOUBLE,
                  rank,
                  tag,
                  communicator,
                  &requests.back());
    };
    for (const bool is_sent : {false, true})
      {
        double *of_own = work.data();
        for (const Neighbour &neighbour : all)
          {
            if (is_sent == to_owners)
              message(is_sent,
                      others + n * neighbour.first,
                      neighbour.end - neighbour.first,
                      neighbour.rank);
            else
              message(is_sent, of_own, neighbour.own.size(), neighbour.rank);
            of_own += n * neighbour.own.size();
          }
      }
    AssertThrowMPI(
      MPI_Waitall(requests.size(), requests.data(), MPI_STATUSES_IGNORE));
  }

  void
  NodeExchange::update(const double      *own,
                       const unsigned int n,
                       double            *others) const
  {
    work.clear();
    for (const Neighbour &neighbour : all)
      for (const unsigned int node : neighbour.own)
        work.insert(work.end(), own + n * node, own + n * (node + 1));
    exchange(n, /*to_owners=*/false, others);
  }

  void
  NodeExchange::add(double            *own,
                    const unsigned int n,
                    const double      *others) const
  {
    std::size_t n_own = 0;
    for (const Neighbour &neighbour : all)
      n_own += neighbour.own.size();
    work.resize(n * n_own);
    exchange(n, /*to_owners=*/true, const_cast<double *>(others));
    const double *value = work.data();
    for (const Neighbour &neighbour : all)
      for (const unsigned int node : neighbour.own)
        for (unsigned int c = 0; c < n; ++c)
          own[n * node + c] += *value++;
  }
} // namespace emmy
