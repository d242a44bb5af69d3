#pragma once
// State shared by all links: one exchange and one open reduction at a time, finished in the order
// of their start, and counts of the traffic.
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "talus/core/error.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/parallel/traffic.hpp"

namespace talus::detail {

class open_exchange {
 public:
  enum class sizes { unknown, fixed };

  void start(std::span<const neighbour_message> neighbour_messages, sizes how, int rank, int ranks);

  void finish(std::span<const neighbour_message> neighbour_messages, sizes how, int rank);

  void count_collective(int rank);

  void start_reduce(reduction how, std::size_t values, int rank);
  /// Returns how to combine the values.
  reduction finish_reduce(std::size_t values, int rank);
  [[nodiscard]] const traffic& sent() const { return sent_; }

 private:
  traffic sent_;
  std::span<const neighbour_message> parcels_;
  sizes how_ = sizes::unknown;
  bool open_ = false;
  reduction how_reduced_ = reduction::sum;
  std::size_t values_ = 0;
  bool reducing_ = false;
};

/// Throws because the message of a neighbour has another size than expected.
[[noreturn]] void fail_size(int rank, const neighbour_message& p, std::optional<std::size_t> came);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/parallel/detail/open_exchange_definitions.hpp"
#endif
