#pragma once
// Ranks inside one process: a mailbox for each, a barrier for collectives, and the error that ends
// all ranks. Memory grows linearly with ranks and connections.
//
// Blocked ranks sleep. Only other ranks can wake them, so the last rank to block detects the
// deadlock and reports it.
#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/parallel/detail/wait_monitor.hpp"

namespace talus::detail {

class thread_team {
 public:
  enum class meeting { barrier, gather, gather_all, broadcast, reduce };
  struct contribution {
    meeting what = meeting::barrier;
    byte_buffer bytes;
  };

  explicit thread_team(int ranks);
  [[nodiscard]] int size() const { return static_cast<int>(boxes_.size()); }
  /// Sets the waiting time after which a rank is reported, see launch_settings.
  void watch(wait_monitor how) { watch_ = std::move(how); }
  /// The last step that `rank` has completed.
  void note_step(int rank, std::uint64_t step);

  void send(int from, int to, byte_buffer&& bytes);

  /// Waits for one message per parcel, then passes each to take(parcel, buffer).
  template <class Take>
  void receive(int rank, std::span<neighbour_message> neighbour_messages, Take take) {
    mailbox& box = boxes_[static_cast<std::size_t>(rank)];
    std::unique_lock lock(box.mutex);
    box.missing = 0;
    int first_missing = busy;
    for (const neighbour_message& p : neighbour_messages) {
      queue& q = box.from(p.rank);
      if (++q.claimed <= q.messages.size()) continue;
      if (box.missing++ == 0) first_missing = p.rank;
    }
    if (box.missing > 0) sleep(rank, first_missing, lock, box.bell, [&] { return !box.missing; });
    for (neighbour_message& p : neighbour_messages) {
      queue& q = box.from(p.rank);
      q.claimed = 0;
      byte_buffer message = std::move(q.messages.front());
      q.messages.erase(q.messages.begin());  // rarely more than two wait here
      take(p, message);
    }
  }

  /// All ranks bring a contribution; read(all contributions, in order of ranks) runs on each.
  template <class Read>
  void meet(int rank, meeting what, std::span<const std::byte> mine, Read read) {
    contribution bring{what, byte_buffer(mine.begin(), mine.end())};
    std::unique_lock lock(meeting_mutex_);
    if (failed_) throw aborted{};
    // Boards alternate: no rank returns to one before all have read it and met at the other.
    const auto round = round_;
    auto& board = boards_[round % 2];
    board[static_cast<std::size_t>(rank)] = std::move(bring);
    if (++arrived_ == size()) {
      arrived_ = 0;
      ++round_;
      running_ += size() - 1;
      lock.unlock();
      meeting_bell_.notify_all();
    } else {
      sleep(rank, meeting_others, lock, meeting_bell_, [&] { return round_ != round; });
      lock.unlock();
    }
    for (std::size_t r = 0; r < board.size(); ++r)
      if (board[r].what != what)
        fail<std::logic_error>(
            "ranks {} and {} call different collectives: all must call the same, in the same order",
            rank, r);
    read(std::span<const contribution>(board));
  }

  /// A non-blocking collective: bring() stores the contribution of this rank and returns, take()
  /// waits for those of all ranks. Each rank takes before it brings again.
  void bring(int rank, std::span<const std::byte> mine);
  template <class Read>
  void take(int rank, Read read) {
    const auto mine = taken_[static_cast<std::size_t>(rank)]++;
    std::unique_lock lock(open_mutex_);
    if (failed_) throw aborted{};
    if (open_round_ <= mine) {
      ++takers_;
      sleep(rank, meeting_others, lock, open_bell_, [&] { return open_round_ > mine; });
    }
    lock.unlock();
    // As above: no rank writes to this board again before all have read it.
    read(std::span<const contribution>(open_boards_[mine % 2]));
  }

  /// Only the first error counts. Wakes every rank that sleeps, with `aborted`.
  void end_with(std::exception_ptr error) noexcept;

  /// `rank` has returned from its main.
  void leave(int rank) noexcept;

  /// After all ranks are joined.
  void rethrow() const;

 private:
  static constexpr int busy = -1, meeting_others = -2, ended = -3;

  struct queue {
    int sender;
    std::size_t claimed = 0;  // messages the receiver waits for, present ones included
    std::vector<byte_buffer> messages{};
  };
  struct alignas(64) mailbox {
    std::mutex mutex;
    std::condition_variable bell;
    std::size_t missing = 0;
    std::vector<queue> queues;  // sorted by sender

    queue& from(int sender) {
      auto at = std::lower_bound(queues.begin(), queues.end(), sender,
                                 [](const queue& q, int s) { return q.sender < s; });
      if (at == queues.end() || at->sender != sender) {
        at = queues.insert(at, queue{sender});
        at->messages.reserve(2);
      }
      return *at;
    }
  };

  template <class Ready>
  void sleep(int rank, int why, std::unique_lock<std::mutex>& lock, std::condition_variable& bell,
             Ready ready) {
    auto& mine = doing_[static_cast<std::size_t>(rank)];
    mine = why;
    if (--running_ == 0 && !failed_) {
      ++running_;
      const std::string text = everyone_waits();
      mine = busy;
      throw std::logic_error(text);
    }
    const auto woken = [&] { return failed_ || ready(); };  // who wakes it counts it as running
    if (!watch_.active())
      bell.wait(lock, woken);
    else
      for (wait_clock waited(watch_); !bell.wait_for(lock, waited.next(), woken);)
        report_wait(waited);
    mine = busy;
    if (failed_) throw aborted{};
  }

  static void ring(std::mutex& mutex, std::condition_variable& bell) noexcept;

  /// A rank has waited for long: reports the ranks that keep it and others waiting, once for all
  /// ranks.
  [[gnu::cold]] void report_wait(wait_clock& waited);

  [[nodiscard]] std::string everyone_waits() const;

  std::vector<mailbox> boxes_;
  std::vector<std::atomic<int>> doing_;            // busy, ended, ..., or the rank it waits for
  std::vector<std::atomic<std::uint64_t>> steps_;  // that each rank has completed
  wait_monitor watch_;
  std::atomic<int> running_;  // ranks that neither sleep nor have ended
  std::atomic<int> left_ = 0;

  std::mutex meeting_mutex_;
  std::condition_variable meeting_bell_;
  std::array<std::vector<contribution>, 2> boards_;
  std::uint64_t round_ = 0;
  int arrived_ = 0;

  std::mutex open_mutex_;
  std::condition_variable open_bell_;
  std::array<std::vector<contribution>, 2> open_boards_;
  std::vector<std::uint64_t> taken_;  ///< rounds that each rank has taken
  std::uint64_t open_round_ = 0;
  int brought_ = 0;
  int takers_ = 0;  ///< ranks that sleep in take()

  std::atomic<bool> failed_ = false;
  std::mutex error_mutex_;
  std::exception_ptr error_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/parallel/detail/thread_team_definitions.hpp"
#endif
