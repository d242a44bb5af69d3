#pragma once
// Ranks as threads of one process: parallel runs without a launcher, and parallel tests without
// MPI.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <span>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/parallel/detail/open_exchange.hpp"
#include "talus/parallel/detail/thread_team.hpp"
#include "talus/parallel/launch_settings.hpp"
#include "talus/parallel/launcher.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus {

struct threads {
  static constexpr const char* name = "threads";

  /// One rank's end. Made by launch(); must not outlive it.
  class link {
    using byte_buffer = detail::byte_buffer;
    using sizes = detail::open_exchange::sizes;
    using team = detail::thread_team;
    using contributions = std::span<const team::contribution>;

   public:
    static constexpr bool alone = false;

    link(team& others, int rank) : team_(&others), rank_(rank) {}

    [[nodiscard]] int rank() const { return rank_; }
    [[nodiscard]] int size() const { return team_->size(); }
    [[nodiscard]] const traffic& counters() const { return exchange_.sent(); }
    /// The last step that this rank has completed, for the report on ranks that wait for it.
    void note_step(std::uint64_t step) { team_->note_step(rank_, step); }

    void start(std::span<parcel> parcels) { post(parcels, sizes::unknown); }
    void finish(std::span<parcel> parcels) {
      exchange_.finish(parcels, sizes::unknown, rank_);
      team_->receive(rank_, parcels, [](parcel& p, byte_buffer& message) {
        p.out = std::exchange(p.in, std::move(message));  // the old buffer serves the next message
        p.out.clear();
      });
    }
    void start_fixed(std::span<parcel> parcels) {
      fixed_sizes_.clear();
      for (const parcel& p : parcels) fixed_sizes_.push_back(p.out.size());
      post(parcels, sizes::fixed);
    }
    void finish_fixed(std::span<parcel> parcels) {
      exchange_.finish(parcels, sizes::fixed, rank_);
      team_->receive(rank_, parcels, [&](parcel& p, byte_buffer& message) {
        if (message.size() != p.in.size()) detail::fail_size(rank_, p, message.size());
        p.out = std::exchange(p.in, std::move(message));
        p.out.resize(fixed_sizes_[static_cast<std::size_t>(&p - parcels.data())]);
      });
    }

    void barrier() {
      meet(team::meeting::barrier, {}, [](contributions) {});
    }
    [[nodiscard]] std::vector<byte_buffer> gather(const byte_buffer& mine) {
      return collect(team::meeting::gather, mine, rank_ == 0);
    }
    [[nodiscard]] std::vector<byte_buffer> gather_all(const byte_buffer& mine) {
      return collect(team::meeting::gather_all, mine, true);
    }
    void broadcast(byte_buffer& bytes) {
      const auto mine = rank_ == 0 ? std::span<const std::byte>(bytes) : std::span<std::byte>{};
      meet(team::meeting::broadcast, mine, [&](contributions all) {
        if (rank_ != 0) bytes = all[0].bytes;
      });
    }
    void reduce(reduction how, std::span<double> values) { combine_all(how, values); }
    void reduce(reduction how, std::span<std::uint64_t> values) { combine_all(how, values); }
    void start_reduce(reduction how, std::span<const double> values) {
      exchange_.start_reduce(how, values.size(), rank_);
      team_->bring(rank_, std::as_bytes(values));
    }
    void finish_reduce(std::span<double> values) {
      const reduction how = exchange_.finish_reduce(values.size(), rank_);
      team_->take(rank_, [&](contributions all) { combine(how, values, all); });
    }

   private:
    void post(std::span<parcel> parcels, sizes how) {
      exchange_.start(parcels, how, rank_, size());
      for (parcel& p : parcels) team_->send(rank_, p.rank, std::move(p.out));
    }

    template <class Read>
    void meet(team::meeting what, std::span<const std::byte> mine, Read read) {
      exchange_.count_collective(rank_);
      team_->meet(rank_, what, mine, read);
    }

    std::vector<byte_buffer> collect(team::meeting what, const byte_buffer& mine, bool wanted) {
      std::vector<byte_buffer> result;
      meet(what, mine, [&](contributions all) {
        if (wanted)
          for (const auto& each : all) result.push_back(each.bytes);
      });
      return result;
    }

    template <class T>
    void combine_all(reduction how, std::span<T> values) {
      meet(team::meeting::reduce, std::as_bytes(values),
           [&](contributions all) { combine(how, values, all); });
    }
    template <class T>
    void combine(reduction how, std::span<T> values, contributions all) {
      detail::plain_vector<T> theirs(values.size());
      for (std::size_t r = 0; r < all.size(); ++r) {
        if (all[r].bytes.size() != values.size_bytes())
          detail::fail<std::logic_error>("ranks {} and {} reduce different numbers of values",
                                         rank_, r);
        if (values.empty()) continue;
        std::memcpy(r ? theirs.data() : values.data(), all[r].bytes.data(), values.size_bytes());
        if (r) detail::combine<T>(how, values, theirs);
      }
    }

    team* team_;
    int rank_;
    detail::open_exchange exchange_;
    std::vector<std::size_t> fixed_sizes_;
  };

  /// More threads than this only wait for each other.
  static constexpr int most_ranks = 4096;

  /// Calls main(link&) for every rank, rank 0 on the calling thread. The first exception of any
  /// rank wakes all that are blocked, and is rethrown here when all have ended.
  /// More than 4,096 ranks: invalid_argument, before any thread is started. Started by mpirun as
  /// several processes: runtime_error. With settings.give_up a rank that keeps others waiting for
  /// so long ends the process with exit code 1, since no thread can be ended by another.
  template <class Main>
  static void launch(const launch_settings& settings, Main&& main) {
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
    team.watch(detail::wait_watch(settings));
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
      team.end_with(std::make_exception_ptr(std::runtime_error(detail::compose(
          "{} ranks are asked for, but the system gave only {} threads ({}); ask for "
          "fewer, or raise its limit on threads",
          ranks, others.size() + 1, e.what()))));
    }
    for (std::thread& each : others) each.join();
    team.rethrow();
  }

 private:
  static constexpr int closed = 0, open = 1, cancelled = 2;  ///< the gate of launch()
};

}  // namespace talus
