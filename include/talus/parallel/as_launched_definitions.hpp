#pragma once
// The definitions of as_launched.hpp, in the compiled part or in each program.
#include <mpi.h>

#include <boost/mpi/environment.hpp>
#include <memory>
#include <utility>

#include "talus/core/linkage.hpp"
#include "talus/parallel/as_launched.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/parallel/threads.hpp"

namespace talus {
namespace detail {

template <class Transport>
class link_of_transport final : public any_link {
  using link = typename Transport::link;

 public:
  explicit link_of_transport(link&& own) : own_(std::move(own)) {}

  [[nodiscard]] int rank() const override { return own_.rank(); }
  [[nodiscard]] int size() const override { return own_.size(); }
  [[nodiscard]] const traffic& counters() const override { return own_.counters(); }
  void note_step(std::uint64_t step) override {
    if constexpr (requires(link & l) { l.note_step(step); }) own_.note_step(step);
  }
  void start(std::span<neighbour_message> neighbour_messages) override {
    own_.start(neighbour_messages);
  }
  void finish(std::span<neighbour_message> neighbour_messages) override {
    own_.finish(neighbour_messages);
  }
  void start_fixed(std::span<neighbour_message> neighbour_messages) override {
    own_.start_fixed(neighbour_messages);
  }
  void finish_fixed(std::span<neighbour_message> neighbour_messages) override {
    own_.finish_fixed(neighbour_messages);
  }
  void barrier() override { own_.barrier(); }
  [[nodiscard]] std::vector<byte_buffer> gather(const byte_buffer& mine) override {
    return own_.gather(mine);
  }
  [[nodiscard]] std::vector<byte_buffer> gather_all(const byte_buffer& mine) override {
    return own_.gather_all(mine);
  }
  void broadcast(byte_buffer& bytes) override { own_.broadcast(bytes); }
  void reduce(reduction how, std::span<double> values) override { own_.reduce(how, values); }
  void reduce(reduction how, std::span<std::uint64_t> values) override { own_.reduce(how, values); }
  void start_reduce(reduction how, std::span<const double> values) override {
    own_.start_reduce(how, values);
  }
  void finish_reduce(std::span<double> values) override { own_.finish_reduce(values); }
  [[nodiscard]] const boost::mpi::communicator* communicator() const override {
    if constexpr (requires(const link& l) { l.communicator(); })
      return &own_.communicator();
    else
      return nullptr;
  }
  [[nodiscard]] const char* transport_name() const override { return Transport::name; }

 private:
  link own_;
};

/// Whether the ranks are to be MPI processes.
[[nodiscard]] TALUS_MPI_INLINE bool several_processes(const mpi::settings& how) {
  using boost::mpi::environment;
  if (how.communicator || find_launcher().size > 1) return true;
  return environment::initialized() && !environment::finalized() &&
         boost::mpi::communicator{}.size() > 1;
}

}  // namespace detail

TALUS_MPI_INLINE void as_launched::launch_any(const settings& how,
                                              const std::function<void(link&)>& main) {
  const auto launch_with = [&]<class Transport>(Transport) {
    Transport::launch(how, [&](typename Transport::link& chosen) {
      link any(std::make_unique<detail::link_of_transport<Transport>>(std::move(chosen)));
      main(any);
    });
  };
  if (detail::several_processes(how))
    launch_with(mpi{});
  else if (how.ranks > 1)
    launch_with(threads{});
  else
    launch_with(serial{});
}

}  // namespace talus
