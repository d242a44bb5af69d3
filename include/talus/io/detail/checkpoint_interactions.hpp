#pragma once
// The parameters set by world.interaction(...) in a checkpoint.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/io/detail/checkpoint_reader.hpp"
#include "talus/io/detail/checkpoint_writer.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// The pairs of one part that were set: both numbers and the parameters, as bytes.
template <class Part>
struct interaction_entry {
  std::uint32_t low, high;
  given_of<Part> value;
};
template <class Part, class Pairs>
[[nodiscard, gnu::cold]] std::vector<interaction_entry<Part>> given_interactions(
    const Pairs& pairs) {
  std::vector<interaction_entry<Part>> all;
  for (const auto& e : pairs.template given<Part>().entries())
    all.push_back({e.low, e.high, e.value});
  std::sort(all.begin(), all.end(), [](const auto& x, const auto& y) {
    return x.low != y.low ? x.low < y.low : x.high < y.high;
  });
  return all;
}
template <class Part>
[[nodiscard]] std::string path_of_interactions() {
  return compose("/materials/interactions_{}", Part::name);
}

/// Calls f.template operator()<Part>(parameters of all pairs) for the parts of the contact law, if
/// it has any.
template <class Scenario, class F>
void each_part_of_law(const world_state<Scenario>& s, F&& f) {
  if constexpr (Scenario::contact_law::soft)
    Scenario::contact_law::law::each_part(
        [&]<class Part>() { f.template operator()<Part>(s.soft.pairs); });
}

template <class Scenario>
[[gnu::cold]] void put_interactions(const world_state<Scenario>& s,
                                    std::vector<small_dataset>& out) {
  each_part_of_law(s, [&]<class Part>(const auto& pairs) {
    const auto mine = given_interactions<Part>(pairs);
    if (mine.empty()) return;
    constexpr std::size_t size = sizeof(interaction_entry<Part>);
    byte_buffer bytes(mine.size() * size);
    for (std::size_t k = 0; k < mine.size(); ++k)
      std::memcpy(bytes.data() + k * size, &mine[k], size);
    out.push_back({path_of_interactions<Part>(), number_type::u8, bytes.size(), 1, bytes});
  });
}
/// Throws runtime_error if the set-up has set other parameters.
template <class Scenario>
[[gnu::cold]] void require_interactions(const checkpoint_reader& in,
                                        const world_state<Scenario>& s) {
  each_part_of_law(s, [&]<class Part>(const auto& pairs) {
    const auto mine = given_interactions<Part>(pairs);
    const std::string path = path_of_interactions<Part>();
    std::vector<std::byte> bytes;
    if (in.has(path)) bytes = in.numbers<std::byte>(path, number_type::u8);
    bool same = bytes.size() == mine.size() * sizeof(interaction_entry<Part>);
    for (std::size_t k = 0; same && k < mine.size(); ++k) {
      interaction_entry<Part> theirs;
      std::memcpy(static_cast<void*>(&theirs), bytes.data() + k * sizeof theirs, sizeof theirs);
      same =
          theirs.low == mine[k].low && theirs.high == mine[k].high && theirs.value == mine[k].value;
    }
    if (!same)
      fail<std::runtime_error>(
          "is of a run with other parameters of {} (world.interaction): its set-up must give the "
          "same",
          Part::name);
  });
}

}  // namespace talus::detail
