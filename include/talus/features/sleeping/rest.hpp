#pragma once
// Which slow bodies are at rest.
#include <algorithm>
#include <cmath>

#include "talus/body/columns.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// Follows a body that is slow for a given time, and tells at the end whether it rests: it has
/// moved less than a thousandth of its radius and, on average, less in the second half of the time
/// than in the first (a body that drifts, rolls or falls goes as far or farther); or so little that
/// it is `negligible`, as heaps creep under few sweeps. A body whose velocity grows alike for three
/// such times in a row does not rest however slow it is: it begins to slide, roll or tip over.
class rest_judge {
 public:
  static constexpr real most = 1e-3, negligible = 5e-5, round_off = 1e-9;

  rest_judge(real time, real dt) : time_(time), dt_(dt) {}

  /// Adds a step with the velocities v and w, in which the body went dt * moved and turned by
  /// dt * turned. Returns false if the body does not rest.
  [[nodiscard]] bool add(drift_while_slow& m, real radius, const vec3& v, const vec3& w,
                         const vec3& moved, const vec3& turned) const {
    if (m.since == 0) m.v = v, m.w = w;
    m.travel += dt_ * moved, m.turn += dt_ * turned;
    m.farthest = std::max(m.farthest, m.travel.norm() + radius * m.turn.norm());
    m.since += dt_;
    // Three such times end before the body may sleep, whatever the step.
    if (m.since + dt_ <= (1 + real(1e-9)) * time_) {
      if (m.since <= time_ / 2) m.early = m.farthest;
      return true;
    }
    const bool starts = gains_speed(m, radius, v, w) && m.farthest > round_off * radius;
    const bool rests =
        !starts && (m.farthest <= negligible * radius ||
                    (m.farthest <= most * radius && m.farthest <= real(1.5) * m.early));
    begin_anew(m, m.farthest);
    return rests;
  }
  /// Whether the body has stood still but for round-off, and may float.
  [[nodiscard]] static bool stands_still(const drift_while_slow& m, real radius) {
    return std::max(m.farthest, m.last) <= round_off * radius;
  }
  static void restart(drift_while_slow& m) { begin_anew(m, 0), m.steady = 0; }

 private:
  /// Cosine of the angle between two changes of velocity that count as alike, and the least part
  /// of the earlier one that the later one may be.
  static constexpr real alike = 0.95, sustained = 0.8;

  /// At the end of a third, whether its velocity has grown alike in this one and the two before.
  [[nodiscard]] static bool gains_speed(drift_while_slow& m, real radius, const vec3& v,
                                        const vec3& w) {
    const auto product = [&](const vec3& a, const vec3& b, const vec3& c, const vec3& d) {
      return a.dot(c) + radius * radius * b.dot(d);
    };
    const vec3 dv = v - m.v, dw = w - m.w;
    const real now = std::sqrt(product(dv, dw, dv, dw)),
               before = std::sqrt(product(m.dv, m.dw, m.dv, m.dw));
    const bool grows = now > 0 && product(v, w, dv, dw) > 0 && now >= sustained * before &&
                       product(dv, dw, m.dv, m.dw) >= alike * now * before;
    m.steady = grows ? m.steady + 1 : 0;
    m.dv = dv, m.dw = dw;
    return m.steady >= 3;
  }
  static void begin_anew(drift_while_slow& m, real last) {
    m.travel = m.turn = vec3(0, 0, 0);
    m.since = m.early = m.farthest = 0, m.last = last;
  }

  real time_, dt_;
};

}  // namespace talus::detail
