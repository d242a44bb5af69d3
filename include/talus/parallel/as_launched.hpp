#pragma once
// The transport that fits how the program was started: one program for a laptop and a cluster.
#include <mpi.h>

#include <cstdint>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "talus/parallel/mpi.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/parallel/threads.hpp"

namespace talus {

/// mpi under mpirun with several processes (or if the program has initialised MPI with several, or
/// gives a communicator); else threads if more than one rank is asked for; else serial.
struct as_launched {
  static constexpr const char* name = "as_launched";
  using settings = mpi::settings;

  /// Any of the three, chosen call by call: what uses it is compiled once.
  class link {
    using byte_buffer = detail::byte_buffer;

   public:
    static constexpr bool alone = false;

    link(serial::link one) : any_(std::move(one)) {}
    link(threads::link one) : any_(std::move(one)) {}
    link(mpi::link one) : any_(std::move(one)) {}

    [[nodiscard]] int rank() const {
      return std::visit([](const auto& l) { return l.rank(); }, any_);
    }
    [[nodiscard]] int size() const {
      return std::visit([](const auto& l) { return l.size(); }, any_);
    }
    [[nodiscard]] const traffic& counters() const {
      return std::visit([](const auto& l) -> const traffic& { return l.counters(); }, any_);
    }

    void note_step(std::uint64_t step) {
      std::visit(
          [&](auto& l) {
            if constexpr (requires { l.note_step(step); }) l.note_step(step);
          },
          any_);
    }

    void start(std::span<parcel> parcels) {
      std::visit([&](auto& l) { l.start(parcels); }, any_);
    }
    void finish(std::span<parcel> parcels) {
      std::visit([&](auto& l) { l.finish(parcels); }, any_);
    }
    void start_fixed(std::span<parcel> parcels) {
      std::visit([&](auto& l) { l.start_fixed(parcels); }, any_);
    }
    void finish_fixed(std::span<parcel> parcels) {
      std::visit([&](auto& l) { l.finish_fixed(parcels); }, any_);
    }

    void barrier() {
      std::visit([](auto& l) { l.barrier(); }, any_);
    }
    [[nodiscard]] std::vector<byte_buffer> gather(const byte_buffer& mine) {
      return std::visit([&](auto& l) { return l.gather(mine); }, any_);
    }
    [[nodiscard]] std::vector<byte_buffer> gather_all(const byte_buffer& mine) {
      return std::visit([&](auto& l) { return l.gather_all(mine); }, any_);
    }
    void broadcast(byte_buffer& bytes) {
      std::visit([&](auto& l) { l.broadcast(bytes); }, any_);
    }
    void reduce(reduction how, std::span<double> values) {
      std::visit([&](auto& l) { l.reduce(how, values); }, any_);
    }
    void reduce(reduction how, std::span<std::uint64_t> values) {
      std::visit([&](auto& l) { l.reduce(how, values); }, any_);
    }

    void start_reduce(reduction how, std::span<const double> values) {
      std::visit([&](auto& l) { l.start_reduce(how, values); }, any_);
    }
    void finish_reduce(std::span<double> values) {
      std::visit([&](auto& l) { l.finish_reduce(values); }, any_);
    }

    /// Of the MPI processes; null where ranks are none.
    [[nodiscard]] const boost::mpi::communicator* communicator() const {
      const auto* processes = std::get_if<mpi::link>(&any_);
      return processes != nullptr ? &processes->communicator() : nullptr;
    }

    /// The transport in use, for the summary of a run.
    [[nodiscard]] const char* transport_name() const {
      constexpr const char* names[] = {serial::name, threads::name, mpi::name};
      return names[any_.index()];
    }

   private:
    std::variant<serial::link, threads::link, mpi::link> any_;
  };

  /// MPI is initialised only if it is going to be used. Errors as the chosen transport has them.
  template <class Main>
  static void launch(const settings& how, Main&& main) {
    const auto with_any = [&](auto& chosen) {
      link any(std::move(chosen));
      main(any);
    };
    if (several_processes(how))
      mpi::launch(how, with_any);
    else if (how.ranks > 1)
      threads::launch(how, with_any);
    else
      serial::launch(how, with_any);
  }

 private:
  static bool several_processes(const settings& how) {
    using boost::mpi::environment;
    if (how.communicator || detail::find_launcher().size > 1) return true;
    return environment::initialized() && !environment::finalized() &&
           boost::mpi::communicator{}.size() > 1;
  }
};

}  // namespace talus
