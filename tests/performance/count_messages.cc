// Counts what a program sends over MPI: loaded before the program
// (LD_PRELOAD), it stands between the program and MPI. At the end rank 0 writes
// lines "KIND CALLS BYTES" to the file that EMMY_MESSAGES names: of a rank on
// average. Used by messages.sh.

#include <mpi.h>

#include <cstdio>
#include <cstdlib>

namespace
{
  enum Kind
  {
    sends,
    reductions,
    gathers,
    broadcasts,
    others,
    n_kinds
  };
  const char *const names[n_kinds] = {"message",
                                      "reduction",
                                      "gather",
                                      "broadcast",
                                      "other_collective"};
  double            calls[n_kinds], bytes[n_kinds];

  void
  count(const Kind kind, const double n, MPI_Datatype type)
  {
    int size = 0;
    PMPI_Type_size(type, &size);
    ++calls[kind];
    bytes[kind] += n * size;
  }
} // namespace

extern "C"
{
#define SEND(name)                                     \
  int MPI_##name(const void  *data,                    \
                 int          n,                       \
                 MPI_Datatype type,                    \
                 int          to,                      \
                 int          tag,                     \
                 MPI_Comm     ranks)                   \
  {                                                    \
    count(sends, n, type);                             \
    return PMPI_##name(data, n, type, to, tag, ranks); \
  }
#define SEND_LATER(name)                                        \
  int MPI_##name(const void  *data,                             \
                 int          n,                                \
                 MPI_Datatype type,                             \
                 int          to,                               \
                 int          tag,                              \
                 MPI_Comm     ranks,                            \
                 MPI_Request *request)                          \
  {                                                             \
    count(sends, n, type);                                      \
    return PMPI_##name(data, n, type, to, tag, ranks, request); \
  }
  SEND(Send)
  SEND(Rsend)
  SEND(Ssend)
  SEND_LATER(Isend)
  SEND_LATER(Irsend)
  SEND_LATER(Issend)

  int
  MPI_Allreduce(const void  *in,
                void        *out,
                int          n,
                MPI_Datatype type,
                MPI_Op       op,
                MPI_Comm     ranks)
  {
    count(reductions, n, type);
    return PMPI_Allreduce(in, out, n, type, op, ranks);
  }
  int
  MPI_Reduce(const void  *in,
             void        *out,
             int          n,
             MPI_Datatype type,
             MPI_Op       op,
             int          root,
             MPI_Comm     ranks)
  {
    count(reductions, n, type);
    return PMPI_Reduce(in, out, n, type, op, root, ranks);
  }
  int
  MPI_Scan(const void  *in,
           void        *out,
           int          n,
           MPI_Datatype type,
           MPI_Op       op,
           MPI_Comm     ranks)
  {
    count(reductions, n, type);
    return PMPI_Scan(in, out, n, type, op, ranks);
  }
  int
  MPI_Exscan(const void  *in,
             void        *out,
             int          n,
             MPI_Datatype type,
             MPI_Op       op,
             MPI_Comm     ranks)
  {
    count(reductions, n, type);
    return PMPI_Exscan(in, out, n, type, op, ranks);
  }
  int
  MPI_Allgather(const void  *in,
                int          n,
                MPI_Datatype type,
                void        *out,
                int          n_out,
                MPI_Datatype type_out,
                MPI_Comm     ranks)
  {
    count(gathers, n, type);
    return PMPI_Allgather(in, n, type, out, n_out, type_out, ranks);
  }
  int
  MPI_Allgatherv(const void  *in,
                 int          n,
                 MPI_Datatype type,
                 void        *out,
                 const int   *n_out,
                 const int   *places,
                 MPI_Datatype type_out,
                 MPI_Comm     ranks)
  {
    count(gathers, n, type);
    return PMPI_Allgatherv(in, n, type, out, n_out, places, type_out, ranks);
  }
  int
  MPI_Gather(const void  *in,
             int          n,
             MPI_Datatype type,
             void        *out,
             int          n_out,
             MPI_Datatype type_out,
             int          root,
             MPI_Comm     ranks)
  {
    count(gathers, n, type);
    return PMPI_Gather(in, n, type, out, n_out, type_out, root, ranks);
  }
  int
  MPI_Gatherv(const void  *in,
              int          n,
              MPI_Datatype type,
              void        *out,
              const int   *n_out,
              const int   *places,
              MPI_Datatype type_out,
              int          root,
              MPI_Comm     ranks)
  {
    count(gathers, n, type);
    return PMPI_Gatherv(in, n, type, out, n_out, places, type_out, root, ranks);
  }
  int
  MPI_Bcast(void *data, int n, MPI_Datatype type, int root, MPI_Comm ranks)
  {
    count(broadcasts, n, type);
    return PMPI_Bcast(data, n, type, root, ranks);
  }
  int
  MPI_Barrier(MPI_Comm ranks)
  {
    count(others, 0, MPI_BYTE);
    return PMPI_Barrier(ranks);
  }
  int
  MPI_Ibarrier(MPI_Comm ranks, MPI_Request *request)
  {
    count(others, 0, MPI_BYTE);
    return PMPI_Ibarrier(ranks, request);
  }
  int
  MPI_Alltoall(const void  *in,
               int          n,
               MPI_Datatype type,
               void        *out,
               int          n_out,
               MPI_Datatype type_out,
               MPI_Comm     ranks)
  {
    int size = 0;
    PMPI_Comm_size(ranks, &size);
    count(others, double(n) * size, type);
    return PMPI_Alltoall(in, n, type, out, n_out, type_out, ranks);
  }
  int
  MPI_Reduce_scatter(const void  *in,
                     void        *out,
                     const int   *n,
                     MPI_Datatype type,
                     MPI_Op       op,
                     MPI_Comm     ranks)
  {
    int    size = 0;
    double sum  = 0.;
    PMPI_Comm_size(ranks, &size);
    for (int rank = 0; rank < size; ++rank)
      sum += n[rank];
    count(others, sum, type);
    return PMPI_Reduce_scatter(in, out, n, type, op, ranks);
  }

  int
  MPI_Finalize()
  {
    double all_calls[n_kinds], all_bytes[n_kinds];
    int    rank = 0, n_ranks = 1;
    PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
    PMPI_Comm_size(MPI_COMM_WORLD, &n_ranks);
    PMPI_Reduce(
      calls, all_calls, n_kinds, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
    PMPI_Reduce(
      bytes, all_bytes, n_kinds, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
    const char *const name = std::getenv("EMMY_MESSAGES");
    if (rank == 0 && name)
      if (std::FILE *const file = std::fopen(name, "w"))
        {
          for (int kind = 0; kind < n_kinds; ++kind)
            std::fprintf(file,
                         "%s %.17g %.17g\n",
                         names[kind],
                         all_calls[kind] / n_ranks,
                         all_bytes[kind] / n_ranks);
          std::fclose(file);
        }
    return PMPI_Finalize();
  }
}
