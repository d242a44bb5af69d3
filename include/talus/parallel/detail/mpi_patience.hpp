#pragma once
// Waiting in MPI without hanging on a rank whose program has ended: after a second of waiting a
// rank begins to check whether the other rank still runs.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

#include "talus/core/error.hpp"
#include "talus/parallel/detail/mpi_verdict.hpp"
#include "talus/parallel/detail/wait_monitor.hpp"

namespace talus::detail {

class mpi_patience {
  using clock = std::chrono::steady_clock;

 public:
  static constexpr int all = -1;

  mpi_patience() = default;  ///< waits for ever
  mpi_patience(mpi_verdict& who_left, wait_monitor& watch) : who_left_(&who_left), watch_(&watch) {}

  /// Calls done() until it is true. Throws runtime_error if `other`, or for a collective call (the
  /// `call`-th) any rank, has ended its program before it came so far, and nothing of it arrived in
  /// a further second. A wait longer than the limit of the watch is reported, and may also end
  /// with a runtime_error.
  template <class Done>
  void wait(int rank, int other, std::uint64_t call, Done&& done) const {
    if (done()) return;
    if (who_left_ == nullptr) {
      while (!done()) {
      }
      return;
    }
    wait_note note{who_left_};
    std::optional<wait_clock> waited;  // a short wait reads no clock
    clock::time_point look;
    int suspect = all;
    for (unsigned polls = 1;; ++polls) {
      if (done()) return;
      if (polls % 64 != 0) continue;
      who_left_->heed_failure();
      if (!waited) {
        waited.emplace(*watch_);
        look = clock::now() + std::chrono::duration_cast<clock::duration>(
                                  std::min(std::chrono::duration<double>(1), waited->next()));
      }
      if (clock::now() < look) continue;
      if (watch_->active() && waited->seconds() >= watch_->patience()) report(note, other, *waited);
      if (suspect != all)
        fail<std::runtime_error>(
            "rank {} waits for rank {}, whose program has ended: all ranks make the same steps and "
            "the same collective calls, and none returns before the others",
            rank, suspect);
      suspect = find_suspect(other, call);
      look = clock::now() + std::chrono::milliseconds(suspect == all ? 200 : 1000);
    }
  }

 private:
  /// The published state of this rank's wait; reset when the wait is over.
  struct wait_note {
    mpi_verdict* where;
    bool noted = false, claimed = false;
    clock::time_point since{};
    ~wait_note() {
      if (claimed) (void)where->claim_report(false);
      if (noted) where->note_wait(0);
    }
  };
  /// First publishes that this rank waits. Slightly later, when the other waiting ranks have done
  /// so too, one rank reports the ranks that do not wait.
  [[gnu::cold]] void report(wait_note& note, int other, const wait_clock& waited) const {
    if (!note.noted) {
      who_left_->note_wait(other == all ? 1 : 2 + static_cast<std::uint64_t>(other));
      note.noted = true, note.since = clock::now();
      return;
    }
    const bool ends = waited.passed();
    const auto time_of_others =
        std::chrono::duration<double>(std::min(1.0, 0.5 * watch_->patience()));
    if (clock::now() - note.since < time_of_others) return;
    if (!ends && (note.claimed || !watch_->mine_to_report(false))) return;
    if (!ends && !(note.claimed = who_left_->claim_report(true))) return;
    const auto waits = who_left_->waits();
    const auto left = waits.empty() ? waits : who_left_->left();
    std::string stuck, waiting;
    int busy_ranks = 0, others = 0;
    for (std::size_t r = 0; r < waits.size(); ++r) {
      if (left[r] > 0) continue;
      std::string& list = waits[r] == 0 ? stuck : waiting;
      if (int& named = waits[r] == 0 ? busy_ranks : others; ++named > 4) continue;
      if (!list.empty()) list += ", ";
      list += compose("rank {}", r);
      if (waits[r] == 1) list += " in a collective call";
      if (waits[r] > 1) list += compose(" for a message of rank {}", waits[r] - 2);
    }
    if (busy_ranks > 4) stuck += compose(" and {} more", busy_ranks - 4);
    if (others > 4) waiting += compose(" and {} more", others - 4);
    if (waits.empty()) stuck = other == all ? "some rank" : compose("rank {}", other);
    if (stuck.empty()) stuck = "each rank";
    if (waiting.empty()) waiting = "this rank";
    if (ends) throw std::runtime_error(watch_->text(stuck, waiting, true));
    watch_->report(stuck, waiting, false);
  }
  [[nodiscard]] int find_suspect(int other, std::uint64_t call) const {
    const auto left = who_left_->left();
    for (std::size_t r = 0; r < left.size(); ++r) {
      const bool concerned = other == all ? left[r] <= call : static_cast<int>(r) == other;
      if (left[r] > 0 && concerned) return static_cast<int>(r);
    }
    return all;
  }

  mpi_verdict* who_left_ = nullptr;
  wait_monitor* watch_ = nullptr;
};

}  // namespace talus::detail
