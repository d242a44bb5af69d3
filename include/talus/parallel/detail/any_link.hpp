#pragma once
// The link of any transport behind one face.
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "talus/core/neighbour_message.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/parallel/traffic.hpp"

namespace boost::mpi {
class communicator;
}

namespace talus::detail {

/// What concepts::link asks for, as virtual functions.
class any_link {
 public:
  any_link() = default;
  any_link(const any_link&) = delete;
  any_link& operator=(const any_link&) = delete;
  virtual ~any_link() = default;

  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  [[nodiscard]] virtual const traffic& counters() const = 0;
  virtual void note_step(std::uint64_t step) = 0;
  virtual void start(std::span<neighbour_message> neighbour_messages) = 0;
  virtual void finish(std::span<neighbour_message> neighbour_messages) = 0;
  virtual void start_fixed(std::span<neighbour_message> neighbour_messages) = 0;
  virtual void finish_fixed(std::span<neighbour_message> neighbour_messages) = 0;
  virtual void barrier() = 0;
  [[nodiscard]] virtual std::vector<byte_buffer> gather(const byte_buffer& mine) = 0;
  [[nodiscard]] virtual std::vector<byte_buffer> gather_all(const byte_buffer& mine) = 0;
  virtual void broadcast(byte_buffer& bytes) = 0;
  virtual void reduce(reduction how, std::span<double> values) = 0;
  virtual void reduce(reduction how, std::span<std::uint64_t> values) = 0;
  virtual void start_reduce(reduction how, std::span<const double> values) = 0;
  virtual void finish_reduce(std::span<double> values) = 0;
  /// Null where ranks are no MPI processes.
  [[nodiscard]] virtual const boost::mpi::communicator* communicator() const = 0;
  [[nodiscard]] virtual const char* transport_name() const = 0;
};

}  // namespace talus::detail
