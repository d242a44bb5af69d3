#pragma once
// The joints that a rank solves exactly, and their bodies, while these are moved to where the
// joints hold.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include "talus/constraint/joint_geometry.hpp"
#include "talus/constraint/line_writer.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/motion/integrate.hpp"
#include "talus/solver/direct/articulations.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// One of them; its bodies are numbered as in jointed_ids.
struct moved_joint {
  const joint_frames* frames;
  const void* anchors;
  void (*write)(const void*, line_writer&);
  const joint_coordinates* coordinates;  ///< at the start of the step, or in its middle
  joint_view solved;                     ///< its rows in the solver
  std::int32_t a, b;
  std::size_t first = 0;  ///< of its rows here
};

/// The bodies of joints with changes of their velocities, or displacements.
template <class State>
class moved_bodies {
 public:
  moved_bodies(const State& s, const plain_vector<joint_end>& ends)
      : s_(s), ends_(ends), motions_(ends.size(), body_motion{}) {}
  /// Moments of inertia that are added to those of a body, if the sum is positive definite.
  void stiffen(std::int32_t k, const mat3& by) {
    if (added_.empty()) added_.assign(ends_.size(), mat3::Zero());
    added_[static_cast<std::size_t>(k)] += by;
  }
  [[nodiscard]] std::size_t size() const { return ends_.size(); }
  [[nodiscard]] bool moves(std::int32_t k) const { return end(k).own && end(k).moves; }
  [[nodiscard]] real inverse_mass(std::int32_t k) const {
    return moves(k) ? real(s_.bodies[number(k)].inverse_mass) : real(0);
  }
  [[nodiscard]] mat3 own_inverse_inertia(std::int32_t k) const {
    const std::size_t i = number(k);
    return s_.has_tensor(i) ? s_.tensor(i)
                            : diagonal_matrix<real>(real(s_.bodies[i].inverse_inertia));
  }
  [[nodiscard]] mat3 inverse_inertia(std::int32_t k) const {
    const mat3 own = own_inverse_inertia(k);
    if (added_.empty()) return own;
    const mat3 sum = own.inverse() + added_[static_cast<std::size_t>(k)];
    const real minor = sum(0, 0) * sum(1, 1) - sum(0, 1) * sum(1, 0);
    const bool definite = sum(0, 0) > 0 && minor > 0 && sum.determinant() > 0;
    return definite ? sum.inverse() : own;
  }
  [[nodiscard]] const body_motion& motion(std::int32_t k) const {
    return motions_[static_cast<std::size_t>(k)];
  }
  void add(std::int32_t k, const body_motion& d) {
    body_motion& x = motions_[static_cast<std::size_t>(k)];
    x.v += d.v, x.w += d.w;
  }
  void clear() { motions_.assign(motions_.size(), body_motion{}); }

 private:
  [[nodiscard]] const joint_end& end(std::int32_t k) const {
    return ends_[static_cast<std::size_t>(k)];
  }
  [[nodiscard]] std::size_t number(std::int32_t k) const {
    return static_cast<std::size_t>(end(k).number);
  }
  const State& s_;
  const plain_vector<joint_end>& ends_;
  plain_vector<body_motion> motions_;
  plain_vector<mat3> added_;
};

/// Adds the poses of global bodies after a further time of `ahead`.
template <class Scenario>
void locate_global_ends(world_state<Scenario>& s, plain_vector<joint_end>& ends, real ahead) {
  const jointed_ids& ids = s.joints.ids();
  s.each_shape([&](auto& b) {
    const auto& store = b.global;
    for (std::size_t j = 0; j < store.size(); ++j) {
      const std::size_t k = ids.find(store.id[j]);
      if (k == jointed_ids::unknown) continue;
      ends[k].position = store.position[j] + ahead * store.velocity[j];
      ends[k].orientation =
          turned<real>(store.pose(j).orientation, ahead * store.angular_velocity[j]);
    }
  });
}

template <class Scenario>
class moved_joints {
  using state_type = world_state<Scenario>;
  using solver_type = std::remove_cvref_t<decltype(std::declval<state_type&>().solver)>;

 public:
  /// After the integration; global bodies are taken where they will be after `ahead`.
  moved_joints(state_type& s, real ahead)
      : ends(find_joint_ends(s)), bodies(s.solver, ends), s_(s) {
    locate_global_ends(s, ends, ahead);
    const jointed_ids& ids = s.joints.ids();
    std::size_t rows = 0;
    s.joints.each_kind([&](auto& of_kind) {
      using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
      list_in_use<false>(of_kind.list).edit_interior_contacts([&](auto& c) {
        auto& r = of_kind.records[c.record];
        const moved_joint one{&r.anchors.frames,
                              &r.anchors,
                              [](const void* x, line_writer& to) {
                                kind::write(*static_cast<const typename kind::anchors*>(x), to);
                              },
                              &r.coordinates,
                              c.view(),
                              static_cast<std::int32_t>(ids.find(r.key.a)),
                              static_cast<std::int32_t>(ids.find(r.key.b)),
                              rows};
        rows += static_cast<std::size_t>(kind::rows);
        all.push_back(one);
      });
    });
    lines_.resize(rows), impulses_.assign(rows, 0);
  }

  plain_vector<moved_joint> all;
  plain_vector<joint_end> ends;
  moved_bodies<solver_type> bodies;

  [[nodiscard]] std::span<joint_line> lines(const moved_joint& j) {
    return {lines_.data() + j.first, static_cast<std::size_t>(j.solved.rows)};
  }
  [[nodiscard]] std::span<const real> impulses(const moved_joint& j) const {
    return {impulses_.data() + j.first, static_cast<std::size_t>(j.solved.rows)};
  }
  [[nodiscard]] joint_geometry geometry(const moved_joint& j,
                                        const plain_vector<joint_end>& at) const {
    const joint_end &a = at[index(j.a)], &b = at[index(j.b)];
    return geometry_of(*j.frames, {a.position, a.orientation},
                       {seen_from(s_, a.position, b.position), b.orientation});
  }
  /// Writes the rows of a joint there.
  void write(const moved_joint& j, const joint_geometry& g) {
    const jointed_body still{};
    joint_coordinates coordinates = *j.coordinates;
    std::fill(lines(j).begin(), lines(j).end(), joint_line{});
    line_writer writer(lines(j), coordinates, g, still, still, {.dt = 1});
    j.write(j.anchors, writer);
  }
  /// The largest error of its rows, over the lengths of which they consist.
  [[nodiscard]] real error(const moved_joint& j, const joint_geometry& g) {
    const real length = g.arm_a.norm() + g.arm_b.norm() + g.gap.norm() +
                        ends[index(j.a)].position.norm() + ends[index(j.b)].position.norm();
    real worst = 0;
    for (const joint_line& x : lines(j)) {
      if (x.use == line_use::off || x.use == line_use::drives) continue;
      if (x.use == line_use::limits && x.error >= 0) continue;
      worst = std::max(worst, std::abs(x.error) / (x.force == vec3(0, 0, 0) ? real(1) : length));
    }
    return worst;
  }
  /// The error before the last iterate().
  [[nodiscard]] real first_error() const { return first_error_; }
  /// Repeats: measure() writes the rows with their targets, may set motions, which are 0 before,
  /// and returns the largest error; the joints are solved; move() applies the motions of `bodies`.
  /// Returns the last error.
  template <class Measure, class Move>
  real iterate(int least, Measure&& measure, Move&& move) {
    constexpr int most = 30, most_idle = 3;
    real best = unbounded;
    for (int k = 0, idle = 0;; ++k) {
      bodies.clear();
      const real worst = measure();
      idle += !(worst < real(0.5) * best);
      if (k == 0) first_error_ = worst;
      if (k == most || (k >= least && (worst <= enough || idle == most_idle))) return worst;
      best = std::min(best, worst);
      impulses_.assign(impulses_.size(), 0);
      if (k == 0) {
        plain_vector<joint_view> views;
        for (const moved_joint& j : all)
          views.push_back({j.a, j.b, j.solved.rows, lines_.data() + j.first,
                           impulses_.data() + j.first, nullptr});
        system_.gather({views.data(), views.size()}, bodies);
      }
      system_.solve(bodies);
      move();
    }
  }

 private:
  static constexpr real enough = 4e-15;
  static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

  state_type& s_;
  plain_vector<joint_line> lines_;
  plain_vector<real> impulses_;
  real first_error_ = 0;
  articulations system_;
};

}  // namespace talus::detail
