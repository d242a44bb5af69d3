#pragma once
// The definitions of open_exchange.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/detail/open_exchange.hpp"

namespace talus::detail {

TALUS_INLINE void open_exchange::start(std::span<const neighbour_message> neighbour_messages,
                                       sizes how, int rank, int ranks) {
  if (open_)
    fail<std::logic_error>("rank {} starts an exchange before it has finished the last one", rank);
  for (const neighbour_message& p : neighbour_messages) {
    if (p.rank < 0 || p.rank >= ranks)
      fail<std::invalid_argument>(
          "rank {} has a neighbour_message for rank {}, but ranks are 0 to {}", rank, p.rank,
          ranks - 1);
    sent_.bytes += p.out.size();
  }
  sent_.messages += neighbour_messages.size();
  parcels_ = neighbour_messages;
  how_ = how;
  open_ = true;
}

TALUS_INLINE void open_exchange::finish(std::span<const neighbour_message> neighbour_messages,
                                        sizes how, int rank) {
  if (!open_ || how != how_ || neighbour_messages.data() != parcels_.data() ||
      neighbour_messages.size() != parcels_.size())
    fail<std::logic_error>(
        "rank {} finishes an exchange that it has not started: start and finish (start_fixed and "
        "finish_fixed) take the same neighbour_messages, in turn",
        rank);
  open_ = false;
}

TALUS_INLINE void open_exchange::count_collective(int rank) {
  if (open_) fail<std::logic_error>("rank {} calls a collective inside an exchange", rank);
  ++sent_.collectives;
}

TALUS_INLINE void open_exchange::start_reduce(reduction how, std::size_t values, int rank) {
  if (reducing_)
    fail<std::logic_error>("rank {} starts a reduction before it has finished the last one", rank);
  count_collective(rank);
  how_reduced_ = how;
  values_ = values;
  reducing_ = true;
}

TALUS_INLINE reduction open_exchange::finish_reduce(std::size_t values, int rank) {
  if (!reducing_ || values != values_)
    fail<std::logic_error>(
        "rank {} finishes a reduction that it has not started: start_reduce and finish_reduce "
        "take the same number of values, in turn",
        rank);
  reducing_ = false;
  return how_reduced_;
}

TALUS_INLINE void fail_size(int rank, const neighbour_message& p, std::optional<std::size_t> came) {
  fail<std::runtime_error>(
      "rank {} expected {} bytes from rank {}, but {} came: the two ranks disagree about what they "
      "share, or one has called start and the other start_fixed",
      rank, p.in.size(), p.rank, came ? std::to_string(*came) : "more");
}

}  // namespace talus::detail
