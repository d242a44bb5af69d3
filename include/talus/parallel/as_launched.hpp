#pragma once
// The transport that fits how the program was started: one program for a laptop and a cluster.
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "talus/parallel/detail/any_link.hpp"
#include "talus/parallel/mpi.hpp"

namespace talus {

/// mpi under mpirun with several processes (or if the program has initialised MPI with several, or
/// gives a communicator); else threads if more than one rank is asked for; else serial.
struct as_launched {
  static constexpr const char* name = "as_launched";
  using settings = mpi::settings;

  /// The link of any of the three. Each call is one indirect call, so that what uses it is compiled
  /// once.
  class link {
    using byte_buffer = detail::byte_buffer;

   public:
    static constexpr bool alone = false;

    explicit link(std::unique_ptr<detail::any_link> any) : any_(std::move(any)) {}

    [[nodiscard]] int rank() const { return any_->rank(); }
    [[nodiscard]] int size() const { return any_->size(); }
    [[nodiscard]] const traffic& counters() const { return any_->counters(); }

    void note_step(std::uint64_t step) { any_->note_step(step); }

    void start(std::span<neighbour_message> neighbour_messages) { any_->start(neighbour_messages); }
    void finish(std::span<neighbour_message> neighbour_messages) {
      any_->finish(neighbour_messages);
    }
    void start_fixed(std::span<neighbour_message> neighbour_messages) {
      any_->start_fixed(neighbour_messages);
    }
    void finish_fixed(std::span<neighbour_message> neighbour_messages) {
      any_->finish_fixed(neighbour_messages);
    }

    void barrier() { any_->barrier(); }
    [[nodiscard]] std::vector<byte_buffer> gather(const byte_buffer& mine) {
      return any_->gather(mine);
    }
    [[nodiscard]] std::vector<byte_buffer> gather_all(const byte_buffer& mine) {
      return any_->gather_all(mine);
    }
    void broadcast(byte_buffer& bytes) { any_->broadcast(bytes); }
    void reduce(reduction how, std::span<double> values) { any_->reduce(how, values); }
    void reduce(reduction how, std::span<std::uint64_t> values) { any_->reduce(how, values); }

    void start_reduce(reduction how, std::span<const double> values) {
      any_->start_reduce(how, values);
    }
    void finish_reduce(std::span<double> values) { any_->finish_reduce(values); }

    /// The communicator of the MPI processes; null where ranks are threads or there is one rank.
    [[nodiscard]] const boost::mpi::communicator* communicator() const {
      return any_->communicator();
    }

    /// The transport in use, for the summary of a run.
    [[nodiscard]] const char* transport_name() const { return any_->transport_name(); }

   private:
    std::unique_ptr<detail::any_link> any_;
  };

  /// MPI is initialised only if it is going to be used. Errors as the chosen transport has them.
  template <class Main>
  static void launch(const settings& how, Main&& main) {
    launch_any(how, [&](link& chosen) { main(chosen); });
  }

 private:
  static void launch_any(const settings& how, const std::function<void(link&)>& main);
};

}  // namespace talus

#ifndef TALUS_COMPILED_MPI
#include "talus/parallel/as_launched_definitions.hpp"
#endif
