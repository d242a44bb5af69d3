#pragma once
// What the parallel code asks of a transport. A model must pass tests/parallel/transport_laws.hpp.
#include <concepts>
#include <cstdint>
#include <span>
#include <vector>

#include "talus/parallel/launch_settings.hpp"
#include "talus/parallel/parcel.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/parallel/traffic.hpp"

namespace talus {

/// One rank's end of all its lines. Used by one thread at a time.
///
/// Exchanges: start() posts one message per parcel and returns at once, finish() waits for one
/// message per parcel. Both sides of a pair must list each other, and their exchanges pair up in
/// the order in which they are made; ranks may otherwise drift apart. One exchange is open at a
/// time. The fixed form wants `in` sized to what will come, and throws runtime_error if
/// something else comes; it is the one for the iterations of a solver.
/// Collectives (set-up and outputs only): every rank calls the same ones in the same order.
template <class T>
concept link = std::movable<T> &&
    requires(T l, const T& c, std::span<parcel> parcels, detail::byte_buffer& bytes,
             std::span<double> reals, std::span<std::uint64_t> counts) {
  { T::alone } -> std::convertible_to<bool>;  // true: there never is a second rank
  { c.rank() } -> std::same_as<int>;
  { c.size() } -> std::same_as<int>;
  { c.counters() } -> std::same_as<const traffic&>;
  l.start(parcels);
  l.finish(parcels);
  l.start_fixed(parcels);
  l.finish_fixed(parcels);
  l.barrier();
  { l.gather(bytes) } -> std::same_as<std::vector<detail::byte_buffer>>;  // empty but on rank 0
  { l.gather_all(bytes) } -> std::same_as<std::vector<detail::byte_buffer>>;
  l.broadcast(bytes);  // from rank 0
  l.reduce(reduction::sum, reals);
  l.reduce(reduction::sum, counts);
};

namespace detail {
template <class Link>
struct main_of {
  void operator()(Link&) const {}
};
}  // namespace detail

/// Starts ranks and runs main(link&) on each. An exception on any rank ends all of them: one
/// error reaches the caller (ranks inside the process) or the user (ranks that are processes).
template <class T>
concept transporting = link<typename T::link> && requires(const launch_settings& settings) {
  { T::name } -> std::convertible_to<const char*>;
  T::launch(settings, detail::main_of<typename T::link>{});
};

}  // namespace talus
