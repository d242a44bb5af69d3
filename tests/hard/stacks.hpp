#pragma once
// Stacks, walls and pyramids of boxes, of any size and at any place.
#include "../scenes/solids.hpp"
#include "../validation/record.hpp"
#include "ranks.hpp"

namespace talus::hard {

using namespace talus::validation;

using blocks = scenes::solids;
inline constexpr real g = 9.81;

inline const cuts whole{.cells = {1, 1, 1}};
inline const cuts quarters{.cells = {2, 2, 1}};

/// Scale of a scene: lengths times `unit`, and the time step times its root, about `centre`.
struct frame_of {
  real unit = 1;
  vec3 centre{0, 0, 0};

  [[nodiscard]] real dt() const { return std::sqrt(unit) / 240; }
  [[nodiscard]] vec3 at(const vec3& p) const { return centre + unit * p; }
};

template <class World>
void floor_at(World& w, const frame_of& f, real friction) {
  const auto m = w.material({.friction = friction});
  w.gravity({0, 0, -g});
  w.global([&](auto& s) { s.add(plane{.normal = {0, 0, 1}, .offset = f.centre[2]}, m); });
}

/// Unit boxes on each other; `sway` is their shift to alternating sides.
template <class World>
void stack(World& w, int n, const frame_of& f = {}, real sway = 0) {
  floor_at(w, f, 0.5);
  for (int k = 0; k < n; ++k) {
    const vec3 side{k % 2 ? sway : -sway, k % 4 < 2 ? sway : -sway, 0};
    w.add_if_local(
        body{.shape = box{f.unit * vec3(1, 1, 1)}, .position = f.at(vec3(0, 0, k + 0.5) + side)});
  }
}
template <class World>
void pyramid(World& w, int base, const frame_of& f = {}) {
  floor_at(w, f, 0.6);
  for (int row = 0; row < base; ++row)
    for (int k = 0; k < base - row; ++k)
      w.add_if_local(body{.shape = box{f.unit * vec3(1, 1, 1)},
                          .position = f.at({k + 0.5 * row - 0.5 * base, 0, row + 0.5})});
}
/// Running bond of bricks 1 x 0.5 x 0.5; every other row has half a brick at either end.
template <class World>
void wall(World& w, int rows, int columns, const frame_of& f = {}) {
  floor_at(w, f, 0.5);
  const auto brick = [&](real x, int row, real length) {
    w.add_if_local(body{.shape = box{f.unit * vec3(length, 0.5, 0.5)},
                        .position = f.at({x - 0.5 * columns, 0, 0.5 * row + 0.25})});
  };
  for (int row = 0; row < rows; ++row) {
    if (row % 2 == 0) {
      for (int k = 0; k < columns; ++k) brick(k + 0.5, row, 1);
    } else {
      brick(0.25, row, 0.5);
      for (int k = 1; k < columns; ++k) brick(k, row, 1);
      brick(columns - 0.25, row, 0.5);
    }
  }
}

/// The bodies are at their initial positions, at rest; errors over the unit of length. (They start
/// without impulses, and sink slightly until the iterations have found them.)
inline void check_stands(const std::string& name, const outcome& o, const frame_of& f) {
  CHECK(o.finite);
  check_error(name, "drift at the end", o.drift() / f.unit, 2e-3);
  check_error(name, "furthest from the start at any time", o.furthest() / f.unit, 1e-2);
  check_error(name, "deepest overlap at any time, over the mean radius", o.deepest, 1e-3);
  check_error(name, "kinetic energy at the end, over m g h",
              o.after.kinetic_energy / (o.mass() * g * f.unit), 1e-6);
}

}  // namespace talus::hard
