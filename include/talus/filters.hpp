#pragma once
// Which bodies touch each other: features<contact_filters>. docs/features.md.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "talus/body/body.hpp"
#include "talus/core/error.hpp"
#include "talus/features/contact_filters.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/world/stage_view.hpp"
#include "talus/world/world.hpp"

namespace talus {
namespace detail {

template <class Shape>
[[nodiscard]] system_id filtered_id(handle<Shape> h) {
  return h.id;
}
template <class Shape>
[[nodiscard]] system_id filtered_id(const std::optional<handle<Shape>>& h) {
  return h ? h->id : no_id;
}

/// The ids of two bodies, of which each is named on some rank. Collective.
template <class Scenario>
[[nodiscard, gnu::cold]] std::pair<system_id, system_id> agree_on_pair(world<Scenario>& w,
                                                                       const char* what,
                                                                       system_id a, system_id b) {
  w.require_all_ranks(what);
  // Halves of ids, which are exact, and their negatives: the largest and the least of all ranks.
  constexpr double none = -1e300;
  std::array<double, 8> parts;
  for (std::size_t k = 0; k < 2; ++k) {
    const system_id id = k == 0 ? a : b;
    const auto high = static_cast<double>(value_of(id) >> 32),
               low = static_cast<double>(value_of(id) & 0xffffffff);
    const std::array<double, 4> of_body{high, low, -high, -low};
    for (std::size_t l = 0; l < 4; ++l) parts[4 * k + l] = id == no_id ? none : of_body[l];
  }
  w.link().reduce(reduction::max, std::span<double>(parts));
  const auto whole = [&](std::size_t k) {
    const double* of_body = &parts[4 * k];
    const char* which = k == 0 ? "the first" : "the second";
    if (of_body[0] == none)
      fail<std::invalid_argument>(
          "{} was called with no handle of {} body on any rank: pass what add or add_if_local "
          "returned, on all ranks",
          what, which);
    if (of_body[0] != -of_body[2] || of_body[1] != -of_body[3])
      fail<std::invalid_argument>(
          "{} was called with different bodies as {} one on different ranks: pass handles of one "
          "body, or empty ones, on all ranks",
          what, which);
    return system_id{static_cast<std::uint64_t>(of_body[0]) << 32 |
                     static_cast<std::uint64_t>(of_body[1])};
  };
  const std::pair both(whole(0), whole(1));
  if (both.first == both.second)
    fail<std::invalid_argument>(
        "{} was called with body {} twice, which does not touch itself: pass two bodies", what,
        value_of(both.first));
  return both;
}

/// Forgets the rules of bodies that were destroyed, where rules have become twice as many: a run in
/// which bodies come and go keeps no more rules than it needs. Collective.
template <class Scenario>
[[gnu::cold]] void forget_rules_of_destroyed(world<Scenario>& w) {
  auto& filters = w.template feature<contact_filters>();
  const std::vector<std::uint64_t> named = filters.bodies_to_look_for();
  if (named.empty()) return;
  std::vector<std::uint64_t> there(named.size(), 0);
  const auto mark = [&](system_id id) {
    const auto at = std::lower_bound(named.begin(), named.end(), value_of(id));
    if (at != named.end() && *at == value_of(id)) there[std::size_t(at - named.begin())] = 1;
  };
  state_of(w).each_shape([&](const auto& b) {
    if constexpr (requires { b.movable; })
      for (std::size_t i = 0; i < b.movable.locals; ++i) mark(b.movable.id[i]);
    for (const system_id id : b.global.id) mark(id);
  });
  w.link().reduce(reduction::max, std::span(there));
  std::vector<std::uint64_t> gone;
  for (std::size_t k = 0; k < named.size(); ++k)
    if (there[k] == 0) gone.push_back(named[k]);
  filters.forget_bodies(gone);
}

}  // namespace detail

/// The two bodies do not touch each other from now on: features<contact_filters>. Collective: all
/// ranks call it alike, with a handle or an empty optional handle of each body (some rank must have
/// one). Throws invalid_argument, on all ranks, if none has, if ranks name different bodies, for
/// the same body twice, and where only_between() names the pair. Rules of destroyed bodies are
/// forgotten.
template <class Scenario, class A, class B>
[[gnu::cold]] void keep_apart(world<Scenario>& w, const A& a, const B& b) {
  const auto [first, second] =
      detail::agree_on_pair(w, "keep_apart", detail::filtered_id(a), detail::filtered_id(b));
  w.template feature<contact_filters>().ignore(first, second);
  detail::forget_rules_of_destroyed(w);
}
/// The two bodies touch each other and nothing else from now on; further calls add partners.
/// Collective, and throws, as keep_apart().
template <class Scenario, class A, class B>
[[gnu::cold]] void only_between(world<Scenario>& w, const A& a, const B& b) {
  const auto [first, second] =
      detail::agree_on_pair(w, "only_between", detail::filtered_id(a), detail::filtered_id(b));
  w.template feature<contact_filters>().only_between(first, second);
  detail::forget_rules_of_destroyed(w);
}

}  // namespace talus
