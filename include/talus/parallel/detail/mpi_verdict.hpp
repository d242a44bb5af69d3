#pragma once
// If processes fail, exactly one of them reports: the first to set a flag on rank 0. Beside the
// flag are the ranks that have ended their program normally, so that no rank waits for them.
#include <mpi.h>

#include <algorithm>
#include <boost/mpi/communicator.hpp>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <thread>
#include <vector>

#include "talus/core/run_lock.hpp"

namespace talus::detail {

/// The flag, and after it a number for each rank: 0, or 1 plus the collective calls of its program
/// when that ended. Then whether a long wait is reported, for each rank what it waits for, and
/// whether rank 0, which holds the locks of outputs, has removed them because another rank failed.
/// One-sided (C API: Boost.MPI has no windows), because the other ranks are busy or blocked. All
/// ranks construct and destroy it together. Some installations of MPI have no windows between
/// machines (Debian's Open MPI over Ethernet): then ranks wait for others without end, and each
/// process that fails reports.
class mpi_verdict {
  using clock = std::chrono::steady_clock;

 public:
  explicit mpi_verdict(const boost::mpi::communicator& ranks) : ranks_(ranks) {
    std::uint64_t* words = nullptr;
    const auto size = static_cast<std::size_t>(ranks.size());
    const std::size_t count = ranks.rank() == 0 ? 3 + 2 * size : 0;
    waits_.resize(size);
    MPI_Errhandler before = MPI_ERRHANDLER_NULL;
    MPI_Comm_get_errhandler(ranks, &before);
    MPI_Comm_set_errhandler(ranks, MPI_ERRORS_RETURN);
    static volatile std::sig_atomic_t beyond_limit;
    beyond_limit = 0;
    const auto handler = std::signal(SIGXFSZ, [](int) { beyond_limit = 1; });
    answers_ = MPI_Win_allocate(static_cast<MPI_Aint>(count * sizeof *words), sizeof *words,
                                MPI_INFO_NULL, ranks, &words, &window_) == MPI_SUCCESS;
    std::signal(SIGXFSZ, handler);
    limited_ = !answers_ && beyond_limit != 0;
    MPI_Comm_set_errhandler(ranks, before);
    MPI_Errhandler_free(&before);
    if (!answers_) {
      window_ = MPI_WIN_NULL;
      return;
    }
    MPI_Win_set_errhandler(window_, MPI_ERRORS_RETURN);
    MPI_Win_lock_all(MPI_MODE_NOCHECK, window_);
    std::fill_n(words, count, 0);
    if (count > 0) words_ = words;
    MPI_Win_sync(window_);
    ranks.barrier();
  }
  mpi_verdict(const mpi_verdict&) = delete;
  mpi_verdict& operator=(const mpi_verdict&) = delete;
  ~mpi_verdict() {
    if (window_ == MPI_WIN_NULL) return;
    MPI_Win_unlock_all(window_);
    MPI_Win_free(&window_);
  }

  /// Whether the limit of file sizes leaves no room for the window, which Open MPI keeps in a file.
  /// Other ranks then wait in the constructor without end.
  [[nodiscard]] bool limited() const { return limited_; }

  /// True on the first rank that calls it. Between machines rank 0 may have to answer while it is
  /// computing, so after a second without an answer it is also true: two messages are better than
  /// none.
  [[nodiscard]] bool first() {
    if (window_ == MPI_WIN_NULL) return true;
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
    leave_own_locks();
    const auto deadline = clock::now() + std::chrono::seconds(10);
    while (clock::now() < deadline) {
      ranks_.iprobe();  // lets MPI serve the flag
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    end();
  }

  /// On rank 0, while it waits: takes part in the end if another rank has failed.
  void heed_failure() {
    if (words_ == nullptr) return;
    MPI_Win_sync(window_);
    if (*const_cast<const volatile std::uint64_t*>(words_) != 0) wait_for_the_end();
  }

  /// This rank's program has returned, after so many collective calls.
  void leave(std::uint64_t collectives) {
    if (window_ == MPI_WIN_NULL) return;
    const std::uint64_t mine = collectives + 1;
    MPI_Accumulate(&mine, 1, MPI_UINT64_T, 0, 1 + ranks_.rank(), 1, MPI_UINT64_T, MPI_REPLACE,
                   window_);
    MPI_Win_flush(0, window_);
  }
  /// For each rank 0, or 1 plus the collective calls after which its program returned.
  [[nodiscard]] std::vector<std::uint64_t> left() const {
    std::vector<std::uint64_t> all(static_cast<std::size_t>(ranks_.size()));
    if (window_ == MPI_WIN_NULL) return all;
    MPI_Get_accumulate(nullptr, 0, MPI_UINT64_T, all.data(), ranks_.size(), MPI_UINT64_T, 0, 1,
                       ranks_.size(), MPI_UINT64_T, MPI_NO_OP, window_);
    MPI_Win_flush(0, window_);
    return all;
  }

  /// Publishes that this rank waits: 0 not, 1 in a collective call, 2 + r for a message of rank r.
  void note_wait(std::uint64_t what) {
    note_ = what;
    answered([&](MPI_Request* request) {
      return MPI_Rget_accumulate(&note_, 1, MPI_UINT64_T, &old_note_, 1, MPI_UINT64_T, 0,
                                 2 + ranks_.size() + ranks_.rank(), 1, MPI_UINT64_T, MPI_REPLACE,
                                 window_, request);
    });
  }
  /// The published waits of the ranks; empty if rank 0 does not answer.
  [[nodiscard]] const std::vector<std::uint64_t>& waits() {
    if (!answered([&](MPI_Request* request) {
          return MPI_Rget_accumulate(nullptr, 0, MPI_UINT64_T, waits_.data(), ranks_.size(),
                                     MPI_UINT64_T, 0, 2 + ranks_.size(), ranks_.size(),
                                     MPI_UINT64_T, MPI_NO_OP, window_, request);
        }))
      waits_.clear();
    return waits_;
  }
  /// Takes or returns the right to report a wait. Returns whether this rank has it; without an
  /// answer it has.
  bool claim_report(bool wanted) {
    claim_ = wanted;
    const bool known = answered([&](MPI_Request* request) {
      return MPI_Rget_accumulate(&claim_, 1, MPI_UINT64_T, &old_claim_, 1, MPI_UINT64_T, 0,
                                 1 + ranks_.size(), 1, MPI_UINT64_T, MPI_REPLACE, window_, request);
    });
    return !known || old_claim_ == 0;
  }

  [[noreturn]] void end() {
    leave_locks();
    ranks_.abort(EXIT_FAILURE);
    std::abort();  // not reached; MPI_Abort does not promise that
  }

  /// Before this rank ends the job. Rank 0 removes its locks when it waits next: it has two seconds
  /// for that. (What it leaves then goes with the next run.)
  void leave_locks() {
    leave_own_locks();
    if (ranks_.rank() == 0) return;
    if (window_ == MPI_WIN_NULL)  // rank 0 often is about to fail for the same reason
      return std::this_thread::sleep_for(std::chrono::milliseconds(200));
    const auto deadline = clock::now() + std::chrono::seconds(2);
    (void)first();
    while (clock::now() < deadline && old_left_ == 0 && answered([&](MPI_Request* request) {
             return MPI_Rget_accumulate(nullptr, 0, MPI_UINT64_T, &old_left_, 1, MPI_UINT64_T, 0,
                                        static_cast<MPI_Aint>(locks_left()), 1, MPI_UINT64_T,
                                        MPI_NO_OP, window_, request);
           }))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  /// Starts an access to the window and waits a second for its end. After one without an answer it
  /// starts no other.
  template <class Start>
  bool answered(Start&& start) {
    MPI_Request request = MPI_REQUEST_NULL;
    if (!answers_ || start(&request) != MPI_SUCCESS) return answers_ = false;
    const auto deadline = clock::now() + std::chrono::seconds(1);
    for (int done = 0; clock::now() < deadline;) {
      if (MPI_Test(&request, &done, MPI_STATUS_IGNORE) != MPI_SUCCESS) break;
      if (done) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return answers_ = false;
  }

  /// The place of the last of the words.
  [[nodiscard]] std::size_t locks_left() const {
    return 2 + 2 * static_cast<std::size_t>(ranks_.size());
  }
  /// Removes the locks of this process. Rank 0 tells the others.
  void leave_own_locks() {
    run_lock::leave_all();
    if (words_ == nullptr) return;
    words_[locks_left()] = 1;
    MPI_Win_sync(window_);
  }

  boost::mpi::communicator ranks_;
  std::uint64_t* words_ = nullptr;  ///< on rank 0, if there is a window
  bool answers_ = true, limited_ = false;
  std::uint64_t note_ = 0, old_note_ = 0, claim_ = 0, old_claim_ = 0, old_left_ = 0;
  std::vector<std::uint64_t> waits_;
  MPI_Win window_ = MPI_WIN_NULL;
  int before_ = 0;
};

}  // namespace talus::detail
