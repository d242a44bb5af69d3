#pragma once
// Materials without friction whose contacts have friction, because a pair takes the mean.
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// Whether pairs of one material without friction and one with may take the mean. Alike on all
/// ranks, without communication.
[[nodiscard, gnu::cold]] bool may_be_half_frictionless(const material_table& all);
/// The warning, from the kinds of bodies by material; empty: none. `movable` and `any` have the
/// index of a shape plus one, or 0 if no body is of the material.
[[nodiscard, gnu::cold]] std::string half_frictionless(const material_table& all,
                                                       std::span<const double> movable,
                                                       std::span<const double> any,
                                                       std::span<const char* const> shapes);

/// Collective: the warning about the first pair of materials of bodies that may meet, one of which
/// has no friction while the contacts of both have the mean. Alike on all ranks.
template <class Scenario>
[[nodiscard, gnu::cold]] std::string half_frictionless(world<Scenario>& w) {
  const material_table& all = w.materials();
  if (!Scenario::contact_law::friction || !may_be_half_frictionless(all)) return {};
  std::vector<const char*> shapes;
  std::vector<double> kinds(2 * all.size());
  const auto note = [&](std::size_t which) { kinds[which] = static_cast<double>(shapes.size()); };
  view_of(w).each_shape([&](const auto& b) {
    shapes.push_back(std::remove_cvref_t<decltype(b)>::shape_type::name);
    for (std::size_t i = 0; i < b.movable.locals; ++i) {
      const auto m = static_cast<std::size_t>(b.movable.material[i]);
      note(all.size() + m);
      if (b.movable.inverse_mass[i] > 0) note(m);
    }
    for (std::size_t i = 0; i < b.global.size(); ++i)
      note(all.size() + static_cast<std::size_t>(b.global.material[i]));
  });
  w.link().reduce(reduction::max, std::span(kinds));
  const std::span<const double> of(kinds);
  return half_frictionless(all, of.first(all.size()), of.last(all.size()), shapes);
}

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/observe/half_frictionless_definitions.hpp"
#endif
