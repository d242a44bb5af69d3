#pragma once
// The transport of a single rank: it has no cost and includes no header of MPI.
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "talus/parallel/detail/open_exchange.hpp"
#include "talus/parallel/launch_settings.hpp"
#include "talus/parallel/launcher.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus {

struct serial {
  static constexpr const char* name = "serial";

  /// The only rank. A parcel may be addressed to this rank itself, as in periodic domains.
  class link {
    using byte_buffer = detail::byte_buffer;
    using sizes = detail::open_exchange::sizes;

   public:
    static constexpr bool alone = true;

    [[nodiscard]] int rank() const { return 0; }
    [[nodiscard]] int size() const { return 1; }
    [[nodiscard]] const traffic& counters() const { return exchange_.sent(); }

    void start(std::span<neighbour_message> neighbour_messages) {
      exchange_.start(neighbour_messages, sizes::unknown, 0, 1);
    }
    void finish(std::span<neighbour_message> neighbour_messages) {
      exchange_.finish(neighbour_messages, sizes::unknown, 0);
      for (neighbour_message& p : neighbour_messages) {
        p.in.swap(p.out);
        p.out.clear();
      }
    }
    void start_fixed(std::span<neighbour_message> neighbour_messages) {
      exchange_.start(neighbour_messages, sizes::fixed, 0, 1);
    }
    void finish_fixed(std::span<neighbour_message> neighbour_messages) {
      exchange_.finish(neighbour_messages, sizes::fixed, 0);
      for (neighbour_message& p : neighbour_messages) {
        if (p.in.size() != p.out.size()) detail::fail_size(0, p, p.out.size());
        p.in.swap(p.out);
      }
    }

    void barrier() { exchange_.count_collective(0); }
    [[nodiscard]] std::vector<byte_buffer> gather(const byte_buffer& mine) {
      exchange_.count_collective(0);
      return {mine};
    }
    [[nodiscard]] std::vector<byte_buffer> gather_all(const byte_buffer& mine) {
      return gather(mine);
    }
    void broadcast(byte_buffer&) { exchange_.count_collective(0); }
    void reduce(reduction, std::span<double>) { exchange_.count_collective(0); }
    void reduce(reduction, std::span<std::uint64_t>) { exchange_.count_collective(0); }
    void start_reduce(reduction how, std::span<const double> values) {
      exchange_.start_reduce(how, values.size(), 0);
    }
    void finish_reduce(std::span<double> values) {
      (void)exchange_.finish_reduce(values.size(), 0);
    }

   private:
    detail::open_exchange exchange_;
  };

  /// Calls main(link&). Any decomposition collapses to one domain; more ranks asked for by the
  /// user: invalid_argument. Started by mpirun as several processes: runtime_error.
  template <class Main>
  static void launch(const launch_settings& settings, Main&& main) {
    detail::refuse_launcher(name);
    if (settings.ranks != 0 && settings.ranks != 1)
      detail::fail<std::invalid_argument>(
          "{} ranks are asked for, but the transport 'serial' has 1: choose the transport threads "
          "or as_launched, or ask for 1",
          settings.ranks);
    link only;
    std::forward<Main>(main)(only);
  }
};

}  // namespace talus
