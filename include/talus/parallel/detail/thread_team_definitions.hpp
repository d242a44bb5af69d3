#pragma once
// The definitions of thread_team.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/detail/thread_team.hpp"

namespace talus::detail {

TALUS_INLINE thread_team::thread_team(int ranks)
    : boxes_(static_cast<std::size_t>(ranks)),
      doing_(static_cast<std::size_t>(ranks)),
      steps_(static_cast<std::size_t>(ranks)),
      running_(ranks),
      taken_(static_cast<std::size_t>(ranks)) {
  for (auto& d : doing_) d = busy;
  for (auto& board : boards_) board.resize(boxes_.size());
  for (auto& board : open_boards_) board.resize(boxes_.size());
}

TALUS_INLINE void thread_team::note_step(int rank, std::uint64_t step) {
  steps_[static_cast<std::size_t>(rank)].store(step, std::memory_order_relaxed);
}

TALUS_INLINE void thread_team::send(int from, int to, byte_buffer&& bytes) {
  if (failed_) throw aborted{};
  mailbox& box = boxes_[static_cast<std::size_t>(to)];
  bool complete = false;
  {
    const std::lock_guard lock(box.mutex);
    queue& q = box.from(from);
    q.messages.push_back(std::move(bytes));
    complete = q.messages.size() <= q.claimed && --box.missing == 0;
    if (complete) ++running_;  // before this rank itself can fall asleep
  }
  if (complete) box.bell.notify_one();
}

TALUS_INLINE void thread_team::bring(int rank, std::span<const std::byte> mine) {
  const std::lock_guard lock(open_mutex_);
  if (failed_) throw aborted{};
  auto& board = open_boards_[open_round_ % 2];
  board[static_cast<std::size_t>(rank)] = {meeting::reduce, byte_buffer(mine.begin(), mine.end())};
  if (++brought_ < size()) return;
  brought_ = 0;
  ++open_round_;
  running_ += std::exchange(takers_, 0);  // before this rank itself can fall asleep
  open_bell_.notify_all();
}

TALUS_INLINE void thread_team::end_with(std::exception_ptr error) noexcept {
  {
    const std::lock_guard lock(error_mutex_);
    if (error_) return;
    error_ = std::move(error);
  }
  failed_ = true;
  for (mailbox& box : boxes_) ring(box.mutex, box.bell);
  ring(meeting_mutex_, meeting_bell_);
  ring(open_mutex_, open_bell_);
}

TALUS_INLINE void thread_team::leave(int rank) noexcept {
  doing_[static_cast<std::size_t>(rank)] = ended;
  ++left_;  // before the other: of ranks that end together the last one counts all
  if (--running_ > 0 || left_ == size() || failed_) return;
  end_with(std::make_exception_ptr(std::logic_error(everyone_waits())));
}

TALUS_INLINE void thread_team::rethrow() const {
  if (error_) std::rethrow_exception(error_);
}

TALUS_INLINE void thread_team::ring(std::mutex& mutex, std::condition_variable& bell) noexcept {
  // The empty section prevents a notification between the last check of a waiting thread and its
  // sleep.
  { const std::lock_guard lock(mutex); }
  bell.notify_all();
}

TALUS_INLINE void thread_team::report_wait(wait_clock& waited) {
  const bool ends = waited.passed();
  if (!watch_.mine_to_report(ends)) return;
  std::string stuck, waiting;
  int busy_ranks = 0, others = 0;
  for (int rank = 0; rank < size(); ++rank) {
    const int why = doing_[static_cast<std::size_t>(rank)];
    if (why == ended) continue;
    std::string& list = why == busy ? stuck : waiting;
    if (int& named = why == busy ? busy_ranks : others; ++named > 4) continue;
    if (!list.empty()) list += ", ";
    list += compose("rank {}", rank);
    if (why == busy)
      list += compose(" (after step {})", steps_[static_cast<std::size_t>(rank)].load());
    else if (why == meeting_others)
      list += " in a collective call";
    else
      list += compose(" for a message of rank {}", why);
  }
  if (busy_ranks == 0) return;  // a deadlock is detected elsewhere
  if (busy_ranks > 4) stuck += compose(" and {} more", busy_ranks - 4);
  if (others > 4) waiting += compose(" and {} more", others - 4);
  watch_.report(stuck, waiting, ends);
  if (!ends) return;
  std::fflush(nullptr);
  std::_Exit(EXIT_FAILURE);  // a thread that does not come back cannot be joined
}

TALUS_INLINE std::string thread_team::everyone_waits() const {
  std::string text = "every rank waits for another one, so none can go on:";
  int named = 0;
  for (int n = 0; n < 2 * size() && named < 8; ++n) {  // of many, first those that have ended
    const int rank = n % size(), why = doing_[static_cast<std::size_t>(rank)];
    const bool first = size() > 8 && why == ended;
    if (why == busy || (n < size()) != first) continue;
    text += compose("{} rank {} ", named++ ? "," : "", rank);
    if (why == ended)
      text += "has ended";
    else if (why == meeting_others)
      text += "is in a collective call";
    else
      text += compose("waits for a message from rank {}", why);
  }
  if (named < size()) text += compose(" (of {} ranks)", size());
  return text +
         "; connect both ranks of a pair to each other (check_connections tells which) "
         "and make the same collective calls on all ranks";
}

}  // namespace talus::detail
