#pragma once
// The definitions of threads.hpp, in the compiled part or in each program.
#include <algorithm>
#include <atomic>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "talus/core/linkage.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/parallel/detail/thread_team.hpp"
#include "talus/parallel/launcher.hpp"
#include "talus/parallel/threads.hpp"

namespace talus {

template <class Meeting, class Read>
void threads::link::meet(Meeting what, std::span<const std::byte> mine, Read read) {
  exchange_.count_collective(rank_);
  team_->meet(rank_, what, mine, read);
}

template <class Meeting>
std::vector<detail::byte_buffer> threads::link::collect(Meeting what, const byte_buffer& mine,
                                                        bool wanted) {
  std::vector<byte_buffer> result;
  meet(what, mine, [&](const auto& all) {
    if (wanted)
      for (const auto& each : all) result.push_back(each.bytes);
  });
  return result;
}

template <class T>
void threads::link::combine_all(reduction how, std::span<T> values) {
  meet(detail::thread_team::meeting::reduce, std::as_bytes(values),
       [&](const auto& all) { combine(how, values, all); });
}
template <class T, class Contributions>
void threads::link::combine(reduction how, std::span<T> values, const Contributions& all) {
  detail::plain_vector<T> theirs(values.size());
  for (std::size_t r = 0; r < all.size(); ++r) {
    if (all[r].bytes.size() != values.size_bytes())
      detail::fail<std::logic_error>("ranks {} and {} reduce different numbers of values", rank_,
                                     r);
    if (values.empty()) continue;
    std::memcpy(r ? theirs.data() : values.data(), all[r].bytes.data(), values.size_bytes());
    if (r) detail::combine<T>(how, values, theirs);
  }
}

TALUS_INLINE void threads::link::start(std::span<neighbour_message> neighbour_messages) {
  post(neighbour_messages, sizes::unknown);
}

TALUS_INLINE void threads::link::finish(std::span<neighbour_message> neighbour_messages) {
  exchange_.finish(neighbour_messages, sizes::unknown, rank_);
  team_->receive(rank_, neighbour_messages, [](neighbour_message& p, byte_buffer& message) {
    p.out = std::exchange(p.in, std::move(message));  // the old buffer serves the next message
    p.out.clear();
  });
}

TALUS_INLINE void threads::link::start_fixed(std::span<neighbour_message> neighbour_messages) {
  fixed_sizes_.clear();
  for (const neighbour_message& p : neighbour_messages) fixed_sizes_.push_back(p.out.size());
  post(neighbour_messages, sizes::fixed);
}

TALUS_INLINE void threads::link::finish_fixed(std::span<neighbour_message> neighbour_messages) {
  exchange_.finish(neighbour_messages, sizes::fixed, rank_);
  team_->receive(rank_, neighbour_messages, [&](neighbour_message& p, byte_buffer& message) {
    if (message.size() != p.in.size()) detail::fail_size(rank_, p, message.size());
    p.out = std::exchange(p.in, std::move(message));
    p.out.resize(fixed_sizes_[static_cast<std::size_t>(&p - neighbour_messages.data())]);
  });
}

TALUS_INLINE void threads::link::barrier() {
  meet(detail::thread_team::meeting::barrier, {}, [](const auto&) {});
}

TALUS_INLINE std::vector<detail::byte_buffer> threads::link::gather(const byte_buffer& mine) {
  return collect(detail::thread_team::meeting::gather, mine, rank_ == 0);
}

TALUS_INLINE std::vector<detail::byte_buffer> threads::link::gather_all(const byte_buffer& mine) {
  return collect(detail::thread_team::meeting::gather_all, mine, true);
}

TALUS_INLINE void threads::link::broadcast(byte_buffer& bytes) {
  const auto mine = rank_ == 0 ? std::span<const std::byte>(bytes) : std::span<std::byte>{};
  meet(detail::thread_team::meeting::broadcast, mine, [&](const auto& all) {
    if (rank_ != 0) bytes = all[0].bytes;
  });
}

TALUS_INLINE void threads::link::reduce(reduction how, std::span<double> values) {
  combine_all(how, values);
}

TALUS_INLINE void threads::link::reduce(reduction how, std::span<std::uint64_t> values) {
  combine_all(how, values);
}

TALUS_INLINE void threads::link::start_reduce(reduction how, std::span<const double> values) {
  exchange_.start_reduce(how, values.size(), rank_);
  team_->bring(rank_, std::as_bytes(values));
}

TALUS_INLINE void threads::link::finish_reduce(std::span<double> values) {
  const reduction how = exchange_.finish_reduce(values.size(), rank_);
  team_->take(rank_, [&](const auto& all) { combine(how, values, all); });
}

TALUS_INLINE void threads::link::post(std::span<neighbour_message> neighbour_messages, sizes how) {
  exchange_.start(neighbour_messages, how, rank_, size());
  for (neighbour_message& p : neighbour_messages) team_->send(rank_, p.rank, std::move(p.out));
}

TALUS_INLINE int threads::link::size() const { return team_->size(); }

TALUS_INLINE void threads::link::note_step(std::uint64_t step) { team_->note_step(rank_, step); }

TALUS_INLINE void threads::launch_each(const launch_settings& settings,
                                       const std::function<void(link&)>& main) {
  constexpr int closed = 0, open = 1, cancelled = 2;  // the gate
  detail::refuse_launcher(name);
  const int ranks = settings.ranks ? settings.ranks : std::max(1, settings.default_ranks);
  if (ranks < 1)
    detail::fail<std::invalid_argument>("{} ranks are asked for; ask for 1 or more", ranks);

  if (ranks > most_ranks)
    detail::fail<std::invalid_argument>(
        "{} ranks are asked for, but one process has at most {} as threads: ask for fewer, or "
        "start the program with mpirun, built with <talus/mpi.hpp>",
        ranks, most_ranks);

  detail::thread_team team(ranks);
  team.watch(detail::wait_monitor(settings));
  std::atomic<int> gate = closed;  // all threads are there before the first begins
  const auto run = [&](int rank) {
    gate.wait(closed);
    if (gate == cancelled) return;
    try {
      link mine(team, rank);
      main(mine);
    } catch (...) {
      team.end_with(std::current_exception());
    }
    team.leave(rank);
  };
  std::vector<std::thread> others;
  others.reserve(static_cast<std::size_t>(ranks - 1));
  try {
    while (std::ssize(others) < ranks - 1)
      others.emplace_back(run, static_cast<int>(std::ssize(others)) + 1);
    gate = open;
    gate.notify_all();
    run(0);
  } catch (const std::system_error& e) {  // run() itself lets nothing out
    gate = cancelled;
    gate.notify_all();
    team.end_with(std::make_exception_ptr(std::runtime_error(
        detail::compose("{} ranks are asked for, but the system gave only {} threads ({}); ask for "
                        "fewer, or raise its limit on threads",
                        ranks, others.size() + 1, e.what()))));
  }
  for (std::thread& each : others) each.join();
  team.rethrow();
}

}  // namespace talus
