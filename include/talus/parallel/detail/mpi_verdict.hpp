#pragma once
// When processes fail, exactly one of them speaks: the first to raise a flag on rank 0.
#include <mpi.h>

#include <boost/mpi/communicator.hpp>
#include <chrono>
#include <cstdlib>
#include <thread>

namespace talus::detail {

/// The flag. One-sided (C API: Boost.MPI has no windows), as the other ranks are busy or blocked
/// somewhere else. Made and destroyed by all ranks together.
class mpi_verdict {
  using clock = std::chrono::steady_clock;

 public:
  explicit mpi_verdict(const boost::mpi::communicator& ranks) : ranks_(ranks) {
    int* flag = nullptr;
    const MPI_Aint bytes = ranks.rank() == 0 ? sizeof(int) : 0;
    MPI_Win_allocate(bytes, sizeof(int), MPI_INFO_NULL, ranks, &flag, &window_);
    MPI_Win_set_errhandler(window_, MPI_ERRORS_RETURN);
    MPI_Win_lock_all(MPI_MODE_NOCHECK, window_);
    if (bytes > 0) *flag = 0;
    MPI_Win_sync(window_);
    ranks.barrier();
  }
  mpi_verdict(const mpi_verdict&) = delete;
  mpi_verdict& operator=(const mpi_verdict&) = delete;
  ~mpi_verdict() {
    MPI_Win_unlock_all(window_);
    MPI_Win_free(&window_);
  }

  /// True on the first rank that asks. Between machines rank 0 may have to answer while it is
  /// computing, so after a second without an answer it is true as well: better two messages
  /// than none.
  [[nodiscard]] bool first() {
    const int one = 1;
    MPI_Request request = MPI_REQUEST_NULL;
    if (MPI_Rget_accumulate(&one, 1, MPI_INT, &before_, 1, MPI_INT, 0, 0, 1, MPI_INT, MPI_REPLACE,
                            window_, &request) != MPI_SUCCESS)
      return true;
    const auto deadline = clock::now() + std::chrono::seconds(1);
    for (int done = 0; clock::now() < deadline;) {
      if (MPI_Test(&request, &done, MPI_STATUS_IGNORE) != MPI_SUCCESS) return true;
      if (done) return before_ == 0;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }

  /// Until the first rank ends the job, which takes milliseconds; ends it itself after ten seconds.
  [[noreturn]] void wait_for_the_end() {
    const auto deadline = clock::now() + std::chrono::seconds(10);
    while (clock::now() < deadline) {
      ranks_.iprobe();  // lets MPI serve the flag
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    end();
  }

  [[noreturn]] void end() {
    ranks_.abort(EXIT_FAILURE);
    std::abort();  // not reached; MPI_Abort does not promise that
  }

 private:
  boost::mpi::communicator ranks_;
  MPI_Win window_ = MPI_WIN_NULL;
  int before_ = 0;
};

}  // namespace talus::detail
