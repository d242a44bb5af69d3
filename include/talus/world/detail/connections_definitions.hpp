#pragma once
// Checks of the connections of a world. Member functions of world.
#include "talus/world/world.hpp"

namespace talus {

template <class Scenario>
void world<Scenario>::check_connections() {
  sections_.require_all_ranks("check_connections", rank());
  if constexpr (domain_type::periodic) {
    require_two_sided_connections();  // no connection was made by hand: nothing else to check
  } else if constexpr (!link_type::alone) {
    require_two_sided_connections();
    talus::check_connections(
        state_.own, [&](const detail::byte_buffer& mine) { return state_.link->gather_all(mine); });
  }
}

/// Throws alike on all ranks if a rank is connected to one that is not connected to it: the two
/// would wait for each other for ever. Costs one reduction if nothing was connected by hand.
template <class Scenario>
void world<Scenario>::require_two_sided_connections() {
  std::uint64_t rewired = rewired_;
  state_.link->reduce(reduction::max, std::span(&rewired, 1));
  if (rewired == 0) return;
  std::vector<int> ranks;
  for (const connection& c : connections()) ranks.push_back(c.rank);
  detail::byte_buffer mine;
  detail::byte_writer(mine).put(std::span<const int>(ranks));
  std::vector<detail::plain_vector<int>> all;
  for (const auto& bytes : state_.link->gather_all(mine))
    all.push_back(detail::byte_reader(bytes).get_all<int>());
  for (std::size_t a = 0; a < all.size(); ++a)
    for (const int b : all[a]) {
      const auto& back = all[static_cast<std::size_t>(b)];
      if (std::find(back.begin(), back.end(), static_cast<int>(a)) == back.end())
        detail::fail<std::runtime_error>(
            "rank {} is connected to rank {}, but rank {} is not connected to rank {}: call "
            "connect on "
            "both sides, each with the region of the other",
            a, b, b, a);
    }
}

}  // namespace talus
