#pragma once
// Loads of joints whose rows depend on each other: the impulses of least norm.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/joint_line.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/articulated_rows.hpp"
#include "talus/solver/direct/articulated_system.hpp"

namespace talus::detail {

/// Whether a row shares loads with those that it depends on: a condition on positions, or a motor
/// or friction below its largest load. Only the motion determines its impulse.
[[nodiscard]] inline bool shares_load(const joint_line& x, real impulse) {
  return x.use == line_use::holds ||
         (drives(x.use) && x.compliance == 0 && impulse > x.least && impulse < x.most);
}

/// Distributes the loads of joints whose rows depend on each other. Among all impulses of such rows
/// that give the bodies the same momenta, it finds those of least norm, where the square of an
/// impulse counts by the mobility of its row. They are the forces of springs that have the
/// mobilities as compliances and bear the momenta. The loads of motors and friction count ten
/// thousand times as much as those of their largest mobility, all torques alike and all forces
/// alike: they are as equal as the others allow.
class shared_loads {
 public:
  /// `structure` has been arranged for these rows.
  shared_loads(articulated_rows& rows, const articulated_system& structure)
      : rows_(rows), springs_(structure) {}

  /// Replaces the impulses, if the solution is as exact as they are, or moves them towards it until
  /// the first of them is at a bound. Returns the part of the way.
  real find() {
    constexpr real weak = 1e-8, enough = 1e-15, useful = 1e-12;
    constexpr int most = 20;
    // Rows as springs, which bear the momenta; bodies as weak springs keep the matrix regular.
    real push = 0, turn = 0;
    rows_.each_row([&](std::size_t j, std::size_t, const joint_line& x, real& r) {
      if (!shares_load(x, r) || !drives(x.use)) return;
      real& most_of = drives_[is_torque(x)];
      most_of = std::max(most_of, rows_.mobility(j, x));
    });
    springs_.clear();
    rows_.set_bodies(springs_, weak);
    plain_vector<real> loads(springs_.size(), 0), left, x(springs_.size(), 0);
    each_shared([&](std::size_t j, std::size_t k, const joint_line& line, real& r, real w) {
      articulated_rows::set_row(springs_, j, k, line, w, w);
      add_momenta(j, line, r, loads);
      // At rest the momenta of the rows cancel, and their round-off is that of each row.
      push = larger(push, std::abs(r) * line.force.norm());
      turn = larger(turn, std::abs(r) * std::max(line.moment_a.norm(), line.moment_b.norm()));
    });
    springs_.factorize();
    const auto size_of = [&](const plain_vector<real>& all, std::size_t from) {
      real sum = 0;
      for (std::size_t i = 0; i < rows_.bodies.size(); ++i)
        for (std::size_t k = from; k < from + 3; ++k)
          sum = larger(sum, std::abs(all[springs_.of_body(static_cast<std::int32_t>(i)) + k]));
      return sum;
    };
    real last = unbounded;
    for (int pass = 0; pass < most; ++pass) {
      left = loads;
      each_shared([&](std::size_t j, std::size_t k, const joint_line& line, real&, real w) {
        const std::size_t row = springs_.of_joint(static_cast<std::int32_t>(j)) + k;
        add_momenta(j, line, -x[row], left);
        left[row] = w * x[row] - of_bodies(j, line, x);
      });
      const real worst = std::max(push > 0 ? size_of(left, 0) / push : real(0),
                                  turn > 0 ? size_of(left, 3) / turn : real(0));
      const bool slow = pass > 1 && !(worst < real(0.5) * last);
      last = worst;
      if (worst <= enough || slow) break;
      springs_.solve(left);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += left[i];
    }
    if (!(last <= useful)) return 1;
    const auto change = [&](std::size_t j, std::size_t k, real r) {
      return x[springs_.of_joint(static_cast<std::int32_t>(j)) + k] - r;
    };
    real part = 1;
    each_shared([&](std::size_t j, std::size_t k, const joint_line& line, real& r, real) {
      const real d = change(j, k, r), room = (d > 0 ? line.most : line.least) - r;
      if (d > 0 ? d > room : d < room) part = std::min(part, room / d);
    });
    each_shared([&](std::size_t j, std::size_t k, const joint_line& line, real& r, real) {
      const real d = change(j, k, r);
      r = std::clamp(part == 1 ? r + d : r + part * d, line.least, line.most);
    });
    return part;
  }

 private:
  /// Calls f(joint, row, line, impulse, mobility) for the rows that only the motion determines.
  template <class F>
  void each_shared(F&& f) {
    rows_.each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      if (!shares_load(x, r)) return;
      if (const real w = rows_.mobility(j, x); w > 0)
        f(j, k, x, r, drives(x.use) ? soft * drives_[is_torque(x)] : w);
    });
  }
  static constexpr real soft = 1e4;
  [[nodiscard]] static std::size_t is_torque(const joint_line& x) {
    return x.force == vec3(0, 0, 0) ? 1 : 0;
  }

  /// Adds the momenta that an impulse gives to the bodies.
  void add_momenta(std::size_t j, const joint_line& x, real r, plain_vector<real>& to) const {
    const auto add = [&](std::int32_t i, real p, const vec3& moment) {
      if (i < 0) return;
      real* at_body = to.data() + springs_.of_body(i);
      for (int k = 0; k < 3; ++k) at_body[k] += p * x.force[k], at_body[3 + k] += p * moment[k];
    };
    add(rows_.ties[j].a, r, x.moment_a), add(rows_.ties[j].b, -r, x.moment_b);
  }
  /// The velocity of a row by those of its bodies.
  [[nodiscard]] real of_bodies(std::size_t j, const joint_line& x,
                               const plain_vector<real>& from) const {
    real sum = 0;
    const auto add = [&](std::int32_t i, real sign, const vec3& moment) {
      if (i < 0) return;
      const real* at_body = from.data() + springs_.of_body(i);
      for (int k = 0; k < 3; ++k)
        sum += sign * (x.force[k] * at_body[k] + moment[k] * at_body[3 + k]);
    };
    add(rows_.ties[j].a, 1, x.moment_a), add(rows_.ties[j].b, -1, x.moment_b);
    return sum;
  }

  articulated_rows& rows_;
  articulated_system springs_;
  std::array<real, 2> drives_{};  ///< the largest mobility of their forces, and of their torques
};

}  // namespace talus::detail
