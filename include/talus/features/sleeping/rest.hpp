#pragma once
// Which slow bodies are at rest.
#include <algorithm>

#include "talus/body/columns.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// Follows a body that is slow for a given time, and tells at the end whether it rests: by its
/// velocity it has moved less than a thousandth of its radius and, on average, less in the second
/// half of the time than in the first (a body that drifts, rolls or falls goes as far or farther);
/// or so little that it is `negligible`, as heaps creep under few sweeps. What the correction of
/// positions moves does not count.
class rest_judge {
 public:
  static constexpr real most = 1e-3, negligible = 5e-5, round_off = 1e-9;

  rest_judge(real time, real dt) : time_(time), dt_(dt) {}

  /// Adds a step. Returns false if the body does not rest.
  [[nodiscard]] bool add(drift_while_slow& m, real radius, const vec3& v, const vec3& w) const {
    m.travel += dt_ * v, m.turn += dt_ * w;
    m.farthest = std::max(m.farthest, m.travel.norm() + radius * m.turn.norm());
    m.since += dt_;
    if (m.since < (1 - real(1e-9)) * time_) {
      if (m.since <= time_ / 2) m.early = m.farthest;
      return true;
    }
    const bool rests = m.farthest <= negligible * radius ||
                       (m.farthest <= most * radius && m.farthest <= real(1.5) * m.early);
    restart(m, m.farthest);
    return rests;
  }
  /// Whether the body has stood still but for round-off, and may float.
  [[nodiscard]] static bool stands_still(const drift_while_slow& m, real radius) {
    return std::max(m.farthest, m.last) <= round_off * radius;
  }
  static void restart(drift_while_slow& m, real last = 0) {
    m.travel = m.turn = vec3(0, 0, 0);
    m.since = m.early = m.farthest = 0, m.last = last;
  }

 private:
  real time_, dt_;
};

}  // namespace talus::detail
