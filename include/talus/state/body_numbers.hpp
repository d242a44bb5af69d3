#pragma once
// The numbers of bodies in the arrays of the solver.
#include <cstddef>
#include <type_traits>

#include "talus/state/state.hpp"

namespace talus::detail {

/// How many bodies the arrays hold; those with a scalar inertia come first.
struct body_counts {
  std::size_t scalar = 0, all = 0;
};

/// Gives each shape its range in the arrays of the response: scalar inertia first, then tensors.
/// The arrays keep the values of the last step until the next one begins.
template <class Scenario>
body_counts number_bodies(held_bodies<Scenario>& s) {
  std::size_t next = 0;
  const auto number = [&](auto& b, bool tensors) {
    if (std::remove_cvref_t<decltype(b.movable)>::tensor != tensors) return;
    b.first = next;
    next += b.movable.size();
  };
  s.each_finite_shape([&](auto& b) { number(b, false); });
  const std::size_t scalar = next;
  s.each_finite_shape([&](auto& b) { number(b, true); });
  return {scalar, next};
}

}  // namespace talus::detail
