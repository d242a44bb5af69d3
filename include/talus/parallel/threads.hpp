#pragma once
// Ranks as threads of one process: parallel runs without a launcher, and parallel tests without
// MPI.
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "talus/core/neighbour_message.hpp"
#include "talus/parallel/detail/open_exchange.hpp"
#include "talus/parallel/launch_settings.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/parallel/traffic.hpp"

namespace talus {
namespace detail {
class thread_team;
}

struct threads {
  static constexpr const char* name = "threads";

  /// One rank's end. Made by launch(); must not outlive it.
  class link {
    using byte_buffer = detail::byte_buffer;
    using sizes = detail::open_exchange::sizes;

   public:
    static constexpr bool alone = false;

    link(detail::thread_team& others, int rank) : team_(&others), rank_(rank) {}

    [[nodiscard]] int rank() const { return rank_; }
    [[nodiscard]] int size() const;
    [[nodiscard]] const traffic& counters() const { return exchange_.sent(); }
    /// The last step that this rank has completed, for the report on ranks that wait for it.
    void note_step(std::uint64_t step);

    void start(std::span<neighbour_message> neighbour_messages);
    void finish(std::span<neighbour_message> neighbour_messages);
    void start_fixed(std::span<neighbour_message> neighbour_messages);
    void finish_fixed(std::span<neighbour_message> neighbour_messages);

    void barrier();
    [[nodiscard]] std::vector<byte_buffer> gather(const byte_buffer& mine);
    [[nodiscard]] std::vector<byte_buffer> gather_all(const byte_buffer& mine);
    void broadcast(byte_buffer& bytes);
    void reduce(reduction how, std::span<double> values);
    void reduce(reduction how, std::span<std::uint64_t> values);
    void start_reduce(reduction how, std::span<const double> values);
    void finish_reduce(std::span<double> values);

   private:
    void post(std::span<neighbour_message> neighbour_messages, sizes how);

    // `Meeting` and `Contributions` are types of thread_team.
    template <class Meeting, class Read>
    void meet(Meeting what, std::span<const std::byte> mine, Read read);
    template <class Meeting>
    std::vector<byte_buffer> collect(Meeting what, const byte_buffer& mine, bool wanted);
    template <class T>
    void combine_all(reduction how, std::span<T> values);
    template <class T, class Contributions>
    void combine(reduction how, std::span<T> values, const Contributions& all);

    detail::thread_team* team_;
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
    launch_each(settings, [&](link& mine) { main(mine); });
  }

 private:
  static void launch_each(const launch_settings& settings, const std::function<void(link&)>& main);
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/threads_definitions.hpp"
#endif
