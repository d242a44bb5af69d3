#pragma once
// Loads of motors whose redundancy closes over the ground: the impulses of least norm, those of
// contacts with what cannot move included.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/constraint/joint_line.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/solver/direct/articulated_rows.hpp"
#include "talus/solver/direct/articulated_system.hpp"
#include "talus/solver/direct/shared_loads.hpp"

namespace talus::detail {

/// A contact of a jointed body with something that cannot move.
struct joint_support {
  static constexpr std::uint32_t elsewhere = ~std::uint32_t{0};
  std::int32_t body = -1;           ///< in the solver's arrays
  std::uint32_t place = elsewhere;  ///< among those of this rank, in the order of the lists
  contact_key key;
  mat3 axes;  ///< rows: the normal towards the body, two tangents
  vec3 arm{0, 0, 0};
  real friction = 0;
  bool slides = false;    ///< faster than by round-off and what sweeps leave
  bool shares = false;    ///< its impulse may have changed
  vec3 impulse{0, 0, 0};  ///< on the body, in the world

  friend bool operator<(const joint_support& x, const joint_support& y) {
    if (x.body != y.body) return x.body < y.body;
    if (x.key.a != y.key.a) return value_of(x.key.a) < value_of(y.key.a);
    if (x.key.b != y.key.b) return value_of(x.key.b) < value_of(y.key.b);
    return x.key.feature < y.key.feature;
  }
};

/// Several motors without compliance that drive wheels over the ground determine their torques
/// only up to sets that the friction of the wheels balances. The rows of contacts that do not slide
/// then share the loads as conditions of joints do; they stay in their cones: where the way to the
/// solution leaves one, it ends there, and goes on without this contact. No body changes its
/// motion.
class supported_loads : private articulated_rows {
 public:
  /// The impulses of `island` and of its `supports`, which are sorted. Returns whether it has any.
  template <class Bodies>
  static bool find(const articulated_rows& island, const Bodies& all,
                   std::span<joint_support> supports, plain_vector<std::int32_t>& number) {
    supported_loads x;
    if (!x.add(island, supports)) return false;
    x.arrange(all, number);
    x.share();
    return true;
  }

 private:
  static constexpr real slack = 1e-9;  ///< of a cone, at whose surface a contact slides

  bool add(const articulated_rows& island, std::span<joint_support> supports) {
    joints = island.joints;
    for (const std::int32_t body : island.bodies) {
      const auto less = [](const joint_support& x, std::int32_t k) { return x.body < k; };
      auto* const begin = supports.data();
      auto* const end = begin + supports.size();
      for (auto* s = std::lower_bound(begin, end, body, less); s != end && s->body == body; ++s)
        supports_.push_back(s);
    }
    if (supports_.empty()) return false;
    lines_.assign(3 * supports_.size(), {}), impulses_.assign(3 * supports_.size(), 0);
    for (std::size_t i = 0; i < supports_.size(); ++i) write(i);
    for (std::size_t i = 0, n = 0; i < supports_.size(); i += n) {
      for (n = 1; i + n < supports_.size() && supports_[i + n]->body == supports_[i]->body;) ++n;
      joints.push_back({supports_[i]->body, -1, static_cast<int>(3 * n), lines_.data() + 3 * i,
                        impulses_.data() + 3 * i});
    }
    return true;
  }
  void write(std::size_t i) {
    const joint_support& s = *supports_[i];
    for (std::size_t k = 0; k < 3; ++k) {
      joint_line& x = lines_[3 * i + k];
      x.force = s.axes.row(static_cast<int>(k));
      x.moment_a = s.arm.cross(x.force);
      x.use = line_use::holds;
      impulses_[3 * i + k] = x.force.dot(s.impulse);
    }
    lines_[3 * i].least = 0;
    if (!(impulses_[3 * i] > 0)) return hold(i);
    if (!(s.friction > 0))
      lines_[3 * i + 1].use = lines_[3 * i + 2].use = line_use::off;
    else if (s.slides && !(sliding(i) < s.friction * impulses_[3 * i] * (1 - slack)))
      hold(i);
  }
  /// Keeps the impulse of a contact as it is.
  void hold(std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k) lines_[3 * i + k].use = line_use::off;
  }
  [[nodiscard]] real sliding(std::size_t i) const {
    return portable::hypot(impulses_[3 * i + 1], impulses_[3 * i + 2]);
  }

  void share() {
    constexpr int most = 8;
    articulated_system structure;
    structure.arrange(static_cast<std::int32_t>(bodies.size()), {ties.data(), ties.size()});
    plain_vector<real> before, parts(supports_.size(), 1);
    for (int pass = 0; pass < most; ++pass) {
      before.clear();
      each_row([&](std::size_t, std::size_t, const joint_line&, real& r) { before.push_back(r); });
      const plain_vector<real> start = impulses_;
      const real part = shared_loads(*this, structure).find();
      real within = 1;
      for (std::size_t i = 0; i < supports_.size(); ++i)
        within = std::min(within, parts[i] = part_of(i, start));
      if (within < 1) {
        std::size_t n = 0;
        each_row([&](std::size_t, std::size_t, const joint_line&, real& r) {
          r = before[n] + within * (r - before[n]), ++n;
        });
        for (std::size_t i = 0; i < supports_.size(); ++i)
          if (parts[i] == within) hold(i);
      }
      for (std::size_t i = 0; i < supports_.size(); ++i)
        if (!(impulses_[3 * i] > 0)) hold(i);
      if (std::min(part, within) == 1) break;
    }
    for (std::size_t i = 0; i < supports_.size(); ++i) {
      vec3 sum{0, 0, 0};
      for (std::size_t k = 0; k < 3; ++k) sum += impulses_[3 * i + k] * lines_[3 * i + k].force;
      supports_[i]->impulse = sum, supports_[i]->shares = true;
    }
  }
  /// The part of the way from `start` on which its impulse is in its cone.
  [[nodiscard]] real part_of(std::size_t i, const plain_vector<real>& start) const {
    if (lines_[3 * i + 1].use != line_use::holds) return 1;
    const real mu = supports_[i]->friction;
    const auto excess = [&](real part) {
      const auto at = [&](std::size_t k) {
        return start[3 * i + k] + part * (impulses_[3 * i + k] - start[3 * i + k]);
      };
      return portable::hypot(at(1), at(2)) - mu * at(0);
    };
    if (excess(1) <= 0) return 1;
    real inside = 0, outside = 1;  // the cone is convex
    for (int k = 0; k < 50; ++k) {
      const real middle = real(0.5) * (inside + outside);
      (excess(middle) <= 0 ? inside : outside) = middle;
    }
    return inside;
  }

  plain_vector<joint_support*> supports_;
  plain_vector<joint_line> lines_;  ///< three of each
  plain_vector<real> impulses_;
};

}  // namespace talus::detail
