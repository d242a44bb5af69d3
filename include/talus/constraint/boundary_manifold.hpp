#pragma once
// The joint solution of all contacts of one pair of bodies, with all other bodies held: for
// contacts between ranks, if a pair has several.
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/constraint/solver_state.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Calls f(first, last) for each run of contacts of one pair of bodies.
template <class F>
void each_manifold(const plain_vector<contact_key>& keys, F&& f) {
  for (std::size_t first = 0, last = 0; first < keys.size(); first = last) {
    while (last < keys.size() && keys[last].same_pair(keys[first])) ++last;
    f(first, last);
  }
}

/// In its lifetime, two bodies are isolated and their masses divided into parts; its end restores
/// the former state.
template <class Real>
class split_pair {
  using state = solver_state_of<Real>;

 public:
  split_pair(state& s, std::int32_t a, std::int32_t b, real parts_a, real parts_b)
      : s_(s), sides_{save(a, parts_a), save(b, parts_b)} {}
  split_pair(const split_pair&) = delete;
  split_pair& operator=(const split_pair&) = delete;
  ~split_pair() {
    for (const side& x : sides_) {
      s_.bodies[x.index] = x.body;
      if (!s_.shift.empty()) s_.shift[x.index] = x.shift;
      if (x.index < s_.first_tensor) continue;
      s_.tensors[x.index - s_.first_tensor] = x.tensor;
      if (!s_.turn.empty()) s_.turn[x.index - s_.first_tensor].w = x.turn;
    }
  }

 private:
  struct side {
    std::size_t index;
    solver_body_of<Real> body;
    mat3 tensor;
    body_shift_of<Real> shift;
    vec3 turn;
  };
  side save(std::int32_t i, real parts) {
    side x;
    x.index = static_cast<std::size_t>(i);
    x.body = s_.bodies[x.index];
    s_.bodies[x.index].inverse_mass *= static_cast<Real>(parts);
    s_.bodies[x.index].inverse_inertia *= static_cast<Real>(parts);
    if (!s_.shift.empty()) x.shift = s_.shift[x.index];
    if (x.index >= s_.first_tensor) {
      mat3& tensor = s_.tensors[x.index - s_.first_tensor];
      x.tensor = tensor;
      tensor *= parts;
      if (!s_.turn.empty()) x.turn = s_.turn[x.index - s_.first_tensor].w;
    }
    return x;
  }

  state& s_;
  side sides_[2];
};

}  // namespace talus::detail
