// Ways of MPI to exchange messages of fixed sizes with two neighbours in a ring: requests made anew
// (what talus does), persistent requests, and a neighbourhood collective. Run under mpirun.
#include <mpi.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "scenes/report.hpp"

namespace {

struct ring {
  MPI_Comm world = MPI_COMM_WORLD, graph = MPI_COMM_NULL;
  int rank = 0, size = 1, next = 0, last = 0;

  ring() {
    MPI_Comm_rank(world, &rank);
    MPI_Comm_size(world, &size);
    next = (rank + 1) % size, last = (rank + size - 1) % size;
    const int others[2] = {last, next};
    MPI_Dist_graph_create_adjacent(world, 2, others, MPI_UNWEIGHTED, 2, others, MPI_UNWEIGHTED,
                                   MPI_INFO_NULL, 0, &graph);
  }
};

/// Buffers to and from both neighbours, one after the other.
struct buffers {
  int bytes;
  std::vector<char> out, in;
  explicit buffers(int n) : bytes(n), out(2 * static_cast<std::size_t>(n)), in(out.size()) {}
};

/// Microseconds of one exchange, at best over rounds, of the slowest rank.
double best_of(const ring& r, const std::function<void()>& exchange) {
  double best = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 30; ++round) {
    const int repeats = 100;
    MPI_Barrier(r.world);
    const double start = MPI_Wtime();
    for (int k = 0; k < repeats; ++k) exchange();
    double mine = 1e6 * (MPI_Wtime() - start) / repeats, slowest = 0;
    MPI_Allreduce(&mine, &slowest, 1, MPI_DOUBLE, MPI_MAX, r.world);
    best = std::min(best, slowest);
  }
  return best;
}

double with_new_requests(const ring& r, buffers& b) {
  const int n = b.bytes;
  return best_of(r, [&] {
    MPI_Request q[4];
    MPI_Irecv(b.in.data(), n, MPI_CHAR, r.last, 0, r.world, &q[0]);
    MPI_Irecv(b.in.data() + n, n, MPI_CHAR, r.next, 1, r.world, &q[1]);
    MPI_Isend(b.out.data(), n, MPI_CHAR, r.next, 0, r.world, &q[2]);
    MPI_Isend(b.out.data() + n, n, MPI_CHAR, r.last, 1, r.world, &q[3]);
    MPI_Waitall(4, q, MPI_STATUSES_IGNORE);
  });
}

double with_persistent_requests(const ring& r, buffers& b) {
  const int n = b.bytes;
  MPI_Request q[4];
  MPI_Recv_init(b.in.data(), n, MPI_CHAR, r.last, 0, r.world, &q[0]);
  MPI_Recv_init(b.in.data() + n, n, MPI_CHAR, r.next, 1, r.world, &q[1]);
  MPI_Send_init(b.out.data(), n, MPI_CHAR, r.next, 0, r.world, &q[2]);
  MPI_Send_init(b.out.data() + n, n, MPI_CHAR, r.last, 1, r.world, &q[3]);
  const double best = best_of(r, [&] {
    MPI_Startall(4, q);
    MPI_Waitall(4, q, MPI_STATUSES_IGNORE);
  });
  for (MPI_Request& each : q) MPI_Request_free(&each);
  return best;
}

double with_neighbourhood_collective(const ring& r, buffers& b) {
  return best_of(r, [&] {
    MPI_Request q;
    MPI_Ineighbor_alltoall(b.out.data(), b.bytes, MPI_CHAR, b.in.data(), b.bytes, MPI_CHAR, r.graph,
                           &q);
    MPI_Wait(&q, MPI_STATUS_IGNORE);
  });
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  const ring r;
  std::string rows;
  for (const int bytes : {64, 1024, 16 << 10, 72 << 10, 512 << 10}) {
    buffers b(bytes);
    bench::record out;
    out.add("ranks", r.size);
    out.add("bytes", bytes);
    out.add("new_requests_us", with_new_requests(r, b));
    out.add("persistent_requests_us", with_persistent_requests(r, b));
    out.add("neighbourhood_collective_us", with_neighbourhood_collective(r, b));
    rows += (rows.empty() ? "" : ",") + out.json();
  }
  if (r.rank == 0) bench::record::write_text("[" + rows + "]\n", "");
  MPI_Finalize();
}
