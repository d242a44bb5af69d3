#pragma once
// The laws of every kind of joint, of the library or user-defined: the law suite of
// concepts::joint_kind.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <talus/concepts.hpp>
#include <talus/constraint/contact_work.hpp>
#include <talus/constraint/frame_around.hpp>
#include <talus/constraint/joint_in_list.hpp>
#include <talus/constraint/joint_rows.hpp>
#include <talus/constraint/solver_state.hpp>
#include <talus/core/random.hpp>

namespace laws {

using namespace talus;
using namespace talus::detail;

inline vec3 any_vector(random_stream& random, real size) {
  return random.uniform(vec3(-size, -size, -size), vec3(size, size, size));
}
inline quat any_turn(random_stream& random) {
  const vec3 v = any_vector(random, 1);
  return quat(random.uniform(-1, 1), v[0], v[1], v[2]).normalized();
}

/// Two bodies with a joint: isotropic, with a tensor of inertia, or immovable.
struct jointed_pair {
  solver_state s;
  jointed_body a, b;
};
enum class side { isotropic, tensor, immovable };

/// Body 0 is isotropic, body 1 has a tensor, body 2 is immovable. In motion about random places.
inline jointed_pair any_pair(random_stream& random, int a, int b) {
  jointed_pair p;
  p.s.first_tensor = 1;
  for (int k = 0; k < 3; ++k) {
    const real mass = random.uniform(0.2, 5);
    const bool still = k == 2;
    p.s.bodies.push_back({still ? vec3(0, 0, 0) : any_vector(random, 1), still ? 0 : 1 / mass,
                          still ? vec3(0, 0, 0) : any_vector(random, 1),
                          k == 0 ? 1 / (mass * random.uniform(0.1, 0.5)) : real(0)});
    p.s.shift.push_back({{0, 0, 0}, p.s.bodies.back().inverse_mass});
  }
  const mat3 axes = frame_around<real>(any_vector(random, 1).normalized());
  mat3 moments = mat3::Zero();
  for (int i = 0; i < 3; ++i) moments(i, i) = random.uniform(0.5, 8);
  p.s.tensors.push_back(axes.transpose() * moments * axes);
  p.s.tensors.push_back(mat3::Zero());
  p.s.turn.resize(2, {});
  const auto place = [&](jointed_body& x, int k) {
    x.at = {any_vector(random, 2), any_turn(random)};
    x.spin = p.s.bodies[static_cast<std::size_t>(k)].w;
    x.velocity = p.s.bodies[static_cast<std::size_t>(k)].v;
  };
  place(p.a, a), place(p.b, b);
  return p;
}

/// The momentum of the pair, and its angular momentum about the origin.
inline wrench momentum_of(const jointed_pair& p, int a, int b) {
  wrench sum;
  const auto add = [&](int k, const jointed_body& x) {
    const auto& body = p.s.bodies[static_cast<std::size_t>(k)];
    if (body.inverse_mass == 0) return;
    const vec3 v = body.v / body.inverse_mass;
    const vec3 spin =
        k == 0 ? vec3(body.w / body.inverse_inertia) : p.s.tensors[0].inverse() * body.w;
    sum.impulse += v;
    sum.moment += x.at.position.cross(v) + spin;
  };
  add(a, p.a), add(b, p.b);
  return sum;
}
inline real kinetic_energy(const solver_state& s) {
  real e = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto& x = s.bodies[k];
    e += 0.5 * x.v.squaredNorm() / x.inverse_mass;
    e += 0.5 *
         (k == 0 ? x.w.squaredNorm() / x.inverse_inertia : x.w.dot(s.tensors[0].inverse() * x.w));
  }
  return e;
}

template <class Kind, class Law>
void for_random(Law&& law) {
  using row = joint_in_list<joint_rows<Kind, solver_state>>;
  static_assert(concepts::joint_kind<Kind>);
  static_assert(concepts::constraint_kind<row>);
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 0}, {0, 2}, {2, 1}, {1, 2}})
    for (std::uint64_t k = 0; k < 50; ++k) {
      random_stream random(23, k);
      CAPTURE(a);
      CAPTURE(b);
      CAPTURE(k);
      law(any_pair(random, a, b), a, b, random);
    }
}

/// The row of a joint of a pair, prepared; the joint was made in the present poses.
template <class Kind>
auto row_of(const Kind& kind, const jointed_pair& p, int a, int b, real dt = 1e-2) {
  joint_in_list<joint_rows<Kind, solver_state>> c{};
  c.a = a, c.b = b;
  joint_coordinates coordinates{};
  c.place(kind.fix(p.a.at, p.b.at), p.a, p.b, {.dt = dt}, coordinates);
  c.prepare(p.s, 1, 1);
  return c;
}

/// `any(random)` makes a joint of the kind, valid for bodies within 2 of the origin.
template <class Kind, class Any>
void obeys_the_laws_of_joints(Any&& any) {
  SUBCASE("after its solution the rows hold, and momentum is conserved") {
    for_random<Kind>([&](jointed_pair p, int a, int b, random_stream& random) {
      auto c = row_of<Kind>(any(random), p, a, b);
      const wrench before = momentum_of(p, a, b);
      c.apply(p.s, c.relax(p.s));
      CHECK(std::sqrt(c.relative_velocity(p.s).squaredNorm()) < 1e-12);
      const wrench after = momentum_of(p, a, b);
      if (a != 2 && b != 2) {
        CHECK((after.impulse - before.impulse).norm() < 1e-12);
        CHECK((after.moment - before.moment).norm() < 1e-11);
      }
      for (const auto& x : p.s.bodies)
        if (x.inverse_mass == 0) CHECK((x.v == vec3(0, 0, 0) && x.w == vec3(0, 0, 0)));
      CHECK(std::sqrt(c.relax(p.s).squaredNorm()) < 1e-11);  // it is done
    });
  }
  SUBCASE("its solution takes energy, as much as its wrenches say, and none if the rows hold") {
    for_random<Kind>([&](jointed_pair p, int a, int b, random_stream& random) {
      auto c = row_of<Kind>(any(random), p, a, b);
      const solver_state first = p.s;
      c.apply(p.s, c.relax(p.s));
      const auto mean = [&](int k, const vec3 solver_body::*of) {
        const auto i = static_cast<std::size_t>(k);
        return vec3(real(0.5) * (first.bodies[i].*of + p.s.bodies[i].*of));
      };
      const real gained = kinetic_energy(p.s) - kinetic_energy(first);
      const real work = work_on_a(c, mean(a, &solver_body::v), mean(a, &solver_body::w)) +
                        work_on_b(c, mean(b, &solver_body::v), mean(b, &solver_body::w));
      CHECK(gained < 1e-12);
      CHECK(std::abs(work - gained) < 1e-11 * (1 + std::abs(gained)));
      const real at_end = work_on_a(c, p.s.bodies[static_cast<std::size_t>(a)].v,
                                    p.s.bodies[static_cast<std::size_t>(a)].w) +
                          work_on_b(c, p.s.bodies[static_cast<std::size_t>(b)].v,
                                    p.s.bodies[static_cast<std::size_t>(b)].w);
      CHECK(std::abs(at_end) < 1e-11);
    });
  }
  SUBCASE("its effective mass is that of a dense computation, also for divided masses") {
    for_random<Kind>([&](jointed_pair p, int a, int b, random_stream& random) {
      const Kind kind = any(random);
      auto c = row_of<Kind>(kind, p, a, b);
      using change = std::remove_cvref_t<decltype(c.impulse_in_frame())>;
      constexpr int n = decltype(c)::rows;
      solver_state still = p.s;
      for (auto& x : still.bodies) x.v = x.w = {0, 0, 0};
      // Column k: the velocity of the rows that a unit impulse in row k causes.
      const auto column = [&](int k, int parts_a, int parts_b) {
        change unit = c.impulse_in_frame() - c.impulse_in_frame();
        unit[k] = 1;
        solver_state by_a = still, by_both = still;
        c.apply_to_a(by_a, unit), c.apply(by_both, unit);
        const change on_a = c.relative_velocity(by_a), all = c.relative_velocity(by_both);
        return change(parts_a * on_a + parts_b * (all - on_a));
      };
      for (const auto& [parts_a, parts_b] : {std::pair{1, 1}, {3, 1}, {2, 5}}) {
        c.prepare(p.s, parts_a, parts_b);
        const change u = c.relative_velocity(p.s), d = c.relax(p.s);
        change sum = u;
        real diagonal = 0;
        for (int k = 0; k < n; ++k) {
          const change w = column(k, parts_a, parts_b);
          sum = sum + d[k] * w;
          diagonal += column(k, 1, 1)[k];
        }
        CHECK(std::sqrt(sum.squaredNorm()) < 1e-11);
        CHECK(std::abs(c.delassus_trace(p.s) - diagonal) < 1e-12 * diagonal);
      }
      // The change of velocity that a change of impulse causes.
      c.prepare(p.s, 1, 1);
      const change d = c.relax(p.s);
      change v = column(0, 1, 1) * d[0];
      for (int k = 1; k < n; ++k) v = v + d[k] * column(k, 1, 1);
      CHECK(std::abs(c.speed_of(d) - std::sqrt(v.squaredNorm())) < 1e-11 * (1 + c.speed_of(d)));
    });
  }
  SUBCASE("nothing depends on the place and the direction of the scene") {
    for_random<Kind>([&](jointed_pair p, int a, int b, random_stream& random) {
      const Kind kind = any(random);
      const auto anchors = kind.fix(p.a.at, p.b.at);
      const quat turn = any_turn(random);
      const vec3 shift = any_vector(random, 50);
      jointed_pair moved = p;
      for (auto& x : moved.s.bodies) x.v = rotated(turn, x.v), x.w = rotated(turn, x.w);
      const mat3 r = turn.toRotationMatrix();
      moved.s.tensors[0] = r * p.s.tensors[0] * r.transpose();
      for (jointed_body* x : {&moved.a, &moved.b}) {
        x->at.position = shift + rotated(turn, x->at.position);
        x->at.orientation = turn * x->at.orientation;
        x->spin = rotated(turn, x->spin);
        x->velocity = rotated(turn, x->velocity);
      }
      const auto solve = [&](jointed_pair& q) {
        joint_in_list<joint_rows<Kind, solver_state>> c{};
        c.a = a, c.b = b;
        joint_coordinates coordinates{};
        c.place(anchors, q.a, q.b, {.dt = 1e-2}, coordinates);
        c.prepare(q.s, 1, 1);
        c.apply(q.s, c.relax(q.s));
        const auto d = c.relax_correction(q.s);
        c.correct_a(q.s, d), c.correct_b(q.s, d);
        return std::pair{c.on_a(), c.on_b()};
      };
      // The bodies have parted a little since they were joined.
      const vec3 apart = any_vector(random, 0.01);
      p.a.at.position += apart;
      moved.a.at.position += rotated(turn, apart);
      const auto [on_a, on_b] = solve(p);
      const auto [moved_a, moved_b] = solve(moved);
      const auto same = [&](const vec3& x, const vec3& y) {
        CHECK((rotated(turn, x) - y).norm() < 1e-10 * (1 + x.norm()));
      };
      same(on_a.impulse, moved_a.impulse), same(on_a.moment, moved_a.moment);
      same(on_b.impulse, moved_b.impulse), same(on_b.moment, moved_b.moment);
      for (std::size_t k = 0; k < 3; ++k) same(p.s.shift[k].v, moved.s.shift[k].v);
    });
  }
  SUBCASE("placed again in the same step, on another rank, it has the same bits after any turns") {
    for_random<Kind>([&](jointed_pair p, int, int, random_stream& random) {
      const auto anchors = any(random).fix(p.a.at, p.b.at);
      p.a.at.orientation = any_turn(random);
      joint_coordinates here{random.uniform(-100, 100), random.uniform(-100, 100)};
      joint_in_list<joint_rows<Kind, solver_state>> c{}, again{};
      c.place(anchors, p.a, p.b, {.dt = 1e-2}, here);
      joint_coordinates there = here;
      again.place(anchors, p.a, p.b, {.dt = 1e-2}, there);
      CHECK(there == here);
      for (std::size_t k = 0; k < c.lines.size(); ++k) {
        CHECK(again.lines[k].error == c.lines[k].error);
        CHECK(again.lines[k].target == c.lines[k].target);
      }
      CHECK(again.correction_rate == c.correction_rate);
    });
  }
  SUBCASE("the correction closes the gap of bodies that have parted, and moves no centre of mass") {
    for_random<Kind>([&](jointed_pair p, int a, int b, random_stream& random) {
      const Kind kind = any(random);
      const auto anchors = kind.fix(p.a.at, p.b.at);
      p.a.spin = p.b.spin = p.a.velocity = p.b.velocity = {0, 0, 0};
      const real dt = 1e-2;
      const auto placed = [&] {
        joint_in_list<joint_rows<Kind, solver_state>> c{};
        c.a = a, c.b = b;
        joint_coordinates coordinates{};
        c.place(anchors, p.a, p.b, {.dt = dt}, coordinates);
        c.prepare(p.s, 1, 1);
        return c;
      };
      const auto size = [](const auto& d) { return std::sqrt(d.squaredNorm()); };
      CHECK(size(placed().relax_correction(p.s)) < 1e-10);  // no gap, no correction
      p.a.at.position += 1e-4 * any_vector(random, 1);
      auto c = placed();
      const auto d = c.relax_correction(p.s);
      CHECK(size(d) > 0);
      c.correct_a(p.s, d), c.correct_b(p.s, d);
      vec3 moved{0, 0, 0};
      for (const auto& x : p.s.shift)
        if (x.inverse_mass != 0) moved += x.v / x.inverse_mass;
      if (a != 2 && b != 2) CHECK(moved.norm() < 1e-11);
      const auto follow = [&](jointed_body& x, int k) {
        const auto i = static_cast<std::size_t>(k);
        x.at.position += dt * p.s.shift[i].v;
        if (k == 0) return;
        const vec3 by = dt * p.s.turn[i - 1].w;
        x.at.orientation =
            (quat(1, by[0] / 2, by[1] / 2, by[2] / 2).normalized() * x.at.orientation).normalized();
      };
      follow(p.a, a), follow(p.b, b);
      for (auto& x : p.s.shift) x.v = {0, 0, 0};
      for (auto& x : p.s.turn) x.w = {0, 0, 0};
      CHECK(size(placed().relax_correction(p.s)) < 1e-3 * size(d));
    });
  }
}

}  // namespace laws
