#pragma once
// With features<driven>: records in each step bodies that contacts make far too fast; see
// speed_leap.hpp.
#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "talus/state/driven_bodies.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The largest plausible ratio of a speed after contacts to any before: collisions of bodies of
/// unlike masses reach 2, in a row of a few more.
inline constexpr real largest_leap = 10;

/// Records if contacts have made a body of this rank faster than any body known to it could: bodies
/// caught between a driven body and a wall hold unbounded impulses, and release them.
template <class Scenario>
void monitor_leaps(world_state<Scenario>& s) {
  real before = s.driving.fastest, after = 0;
  s.each_shape([&](const auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    if constexpr (shape::finite) {
      const auto& store = b.movable;
      for (std::size_t i = 0; i < store.size(); ++i) {
        const std::size_t k = b.first + i;
        before = std::max(before,
                          free_velocity(s, store, i).norm() +
                              store.shape[i].bounding_radius() * store.angular_velocity[i].norm());
        if (i < store.locals && store.moves(i))
          after = std::max(after, solved_velocity(s, store, i, k).norm());
      }
    } else {
      for (std::size_t j = 0; j < b.global.size(); ++j) {
        const vec3 v = b.global.velocity[j], w = b.global.angular_velocity[j];
        before = std::max(before, v.norm());
        if (w == vec3(0, 0, 0)) continue;
        s.each_finite_shape([&](const auto& other) {  // a plane meets them at any place
          for (const vec3& p : other.movable.position)
            before = std::max(before, (v + w.cross(p - b.global.position[j])).norm());
        });
      }
    }
  });
  speed_leap& worst = s.driving.leap;
  const speed_leap now{s.steps + 1, before, after};
  if (now.ratio() > largest_leap && now.ratio() > worst.ratio()) worst = now;
}

}  // namespace talus::detail
