#pragma once
// Frames of contacts, and the change of two bodies by the impulses of a manifold.
#include <cstddef>
#include <cstdint>

#include "talus/constraint/frame_around.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// A contact that can be solved in the frame of its manifold; see general_contact.
template <class Contact>
concept swept_in_manifolds = requires {
  requires Contact::swept_in_manifolds;
};

// Written out, because a sweep consists of them alone.
[[nodiscard]] [[gnu::always_inline]] inline vec3 seen_in(const mat3& f, const vec3& v) {
  return {f(0, 0) * v[0] + f(0, 1) * v[1] + f(0, 2) * v[2],
          f(1, 0) * v[0] + f(1, 1) * v[1] + f(1, 2) * v[2],
          f(2, 0) * v[0] + f(2, 1) * v[1] + f(2, 2) * v[2]};
}
[[nodiscard]] [[gnu::always_inline]] inline vec3 seen_from(const mat3& f, const vec3& v) {
  return {f(0, 0) * v[0] + f(1, 0) * v[1] + f(2, 0) * v[2],
          f(0, 1) * v[0] + f(1, 1) * v[1] + f(2, 1) * v[2],
          f(0, 2) * v[0] + f(1, 2) * v[1] + f(2, 2) * v[2]};
}

/// Changes the velocities of two bodies by an impulse on a, with its moment about the centre of a.
template <bool Paired, class State>
void give_pair(State& s, std::int32_t of_a, std::int32_t of_b, const vec3& offset,
               const vec3& impulse, const vec3& moment) {
  const auto i = static_cast<std::size_t>(of_a);
  using number = typename State::number;
  auto& a = s.bodies[i];
  a.v += in_scalar<number>(vec3(a.inverse_mass * impulse));
  a.w += in_scalar<number>(seen_in(s.tensor(i), moment));
  if constexpr (Paired) {
    const auto j = static_cast<std::size_t>(of_b);
    auto& b = s.bodies[j];
    b.v -= in_scalar<number>(vec3(b.inverse_mass * impulse));
    b.w -= in_scalar<number>(seen_in(s.tensor(j), moment + crossed(offset, impulse)));
  }
}

}  // namespace talus::detail
