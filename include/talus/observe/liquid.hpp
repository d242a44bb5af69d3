#pragma once
// The liquid of a world: films on bodies and bridges between them.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "talus/core/exact_sum.hpp"
#include "talus/features/surface_liquid.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/world/contact_memories.hpp"
#include "talus/world/state_of.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// A bridge between two bodies.
struct liquid_bridge_of {
  system_id a = no_id, b = no_id;  ///< the bodies; b may be global
  std::uint64_t feature = 0;       ///< identifies the point within the pair
  real volume = 0;                 ///< of its liquid, length cubed
};

namespace detail {

/// The volume of liquid in a bridge.
template <class Memory>
[[nodiscard]] real volume_of_bridge(const Memory& m) {
  if constexpr (requires { m.held(); })
    return m.held();
  else
    return m.volume;
}
template <class Part>
        struct is_bridge_law : std::bool_constant < takes_liquid<Part> ||
    requires(const typename Part::parameters& p) {
  Part::rupture_distance(p, real{});
} > {};

}  // namespace detail

/// Calls f(liquid_bridge_of) for all liquid bridges after a step: over all ranks once for each, in
/// the order of the ids. No rank waits for another.
template <class Scenario, class F>
void for_each_bridge(world<Scenario>& w, F&& f) {
  using law = typename Scenario::contact_law::law;
  using bridge =
      detail::find_type<typename Scenario::contact_law::list, detail::is_bridge_law, void>;
  static_assert(!std::is_void_v<bridge>,
                "for_each_bridge needs a law of liquid bridges: add willett_bridge or "
                "rabinovich_bridge to soft_contact<...>");
  auto& s = detail::state_of(w);
  using entry = typename std::remove_reference_t<decltype(s)>::history_type::entry;
  std::vector<const entry*> chosen;
  for (const entry& e : std::as_const(s.history).entries())
    if (detail::volume_of_bridge(law::template of<bridge>(e.memory)) > 0) chosen.push_back(&e);
  if (chosen.empty()) return;
  detail::sort_by_key(chosen);
  detail::each_memory_of<bridge>(detail::body_places<Scenario>(s), chosen, [&](const auto& c) {
    if (c.counts_here) f(liquid_bridge_of{c.a, c.b, c.feature, detail::volume_of_bridge(c.memory)});
  });
}

/// The liquid in all films and bridges, volumes.
struct liquid_content {
  real films = 0, bridges = 0;
  std::uint64_t count = 0;  ///< number of bridges
  [[nodiscard]] real total() const { return films + bridges; }
};

/// Collective: the liquid of all bodies and bridges, alike on all ranks and with the same bits on
/// any number of them.
template <class Scenario>
[[nodiscard]] liquid_content total_liquid(world<Scenario>& w) {
  w.require_all_ranks("total_liquid");
  std::array<detail::exact_sum, 2> sums;
  std::uint64_t count = 0;
  if constexpr (Scenario::template has_feature<surface_liquid>)
    w.for_each_local([&](const auto& body) { sums[0] += body.template get<liquid>(); });
  for_each_bridge(w, [&](const liquid_bridge_of& b) { sums[1] += b.volume, ++count; });
  detail::sum_exactly(w.link(), sums);
  liquid_content all{.films = sums[0].value(), .bridges = sums[1].value()};
  w.link().reduce(reduction::sum, std::span(&count, 1));
  all.count = count;
  return all;
}

}  // namespace talus
