#pragma once
// The definitions of half_frictionless.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/observe/half_frictionless.hpp"

namespace talus::detail {

TALUS_INLINE bool may_be_half_frictionless(const material_table& all) {
  bool smooth = false, rough = false;
  for (std::size_t i = 0; i < all.size(); ++i)
    (all[material_id(i)].friction > 0 ? rough : smooth) = true;
  return smooth && rough && all.rules().friction == pair_rule::mean;
}

TALUS_INLINE std::string half_frictionless(const material_table& all,
                                           std::span<const double> movable,
                                           std::span<const double> any,
                                           std::span<const char* const> shapes) {
  const auto friction = [&](std::size_t i) { return all[material_id(i)].friction; };
  // A body that can move stands for a material whose bodies meet those of the other by that alone.
  const auto shape_of = [&](std::size_t i, std::size_t other) {
    const double kind = movable[other] > 0 ? any[i] : movable[i];
    return shapes[static_cast<std::size_t>(kind) - 1];
  };
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < all.size() && any[i] > 0 && friction(i) == 0; ++j)
      if (any[j] > 0 && friction(j) > 0 && (movable[i] > 0 || movable[j] > 0) &&
          all.own_pair(material_id(i), material_id(j)) == nullptr)
        return compose(
            "material {} (of a {}) has no friction and material {} (of a {}) has {}, and their "
            "contacts take the mean, {}: for a frictionless {} call world.pair_rules with "
            ".friction "
            "= pair_rule::least, or give the pair a value of its own by world.material_pair",
            i, shape_of(i, j), j, shape_of(j, i), text(friction(j)), text(0.5 * friction(j)),
            shape_of(i, j));
  return {};
}

}  // namespace talus::detail
