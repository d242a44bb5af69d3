#pragma once
// The laws of every interaction law, of the library or user-defined: the law suite of
// concepts::interaction_law.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <talus/concepts.hpp>
#include <talus/core/random.hpp>
#include <talus/interaction/soft_contact.hpp>

namespace laws {

using namespace talus;

/// A contact at this gap, of two bodies that approach each other in no special direction.
inline contact_kinematics contact_at(real gap) {
  return {.normal = vec3(1, 2, -2) / 3,
          .gap = gap,
          .velocity = {0.02, -0.01, 0.03},
          .spin = {0.1, 0.2, -0.1},
          .mean_spin = 0.3,
          .mass = 0.7,
          .radius = 0.4,
          .rolling_inertia = 0.2,
          .step = 1e-4};
}
inline real distance(const vec3& x, const vec3& y) { return (x - y).norm(); }

/// The largest gap at which the law acts.
template <class Law>
real range_of(const typename Law::parameters& p, real radius) {
  if constexpr (requires { Law::range(p, radius); })
    return Law::range(p, radius);
  else
    return 0;
}
/// The force as the library uses it: outside the range of the law the force is zero, and the
/// contact ends.
template <class Law>
interaction_force force(const contact_kinematics& c, const typename Law::parameters& p, real dt,
                        typename Law::memory& memory) {
  if (!(c.gap < 0) && !(c.gap < range_of<Law>(p, c.radius))) {
    memory = {};
    return {};
  }
  return Law::force(c, p, dt, memory);
}

/// The memory after a history: approach, and some steps of sliding and rolling at an overlap.
template <class Law>
typename Law::memory used_memory(const typename Law::parameters& p, real overlap) {
  typename Law::memory memory{};
  for (int k = 0; k < 20; ++k) (void)force<Law>(contact_at(-overlap), p, 1e-4, memory);
  return memory;
}

/// Force and moment rotate with the contact.
template <class Law>
void check_frame(const typename Law::parameters& p, real overlap) {
  const quat q = rotation({0.3, -0.5, 0.8}, 1.1);
  const auto turned = [&](const vec3& v) { return rotated(q, v); };
  typename Law::memory here{}, there{};
  interaction_force f, g;
  for (int k = 0; k < 10; ++k) {
    contact_kinematics c = contact_at(-overlap), d = c;
    d.normal = turned(c.normal), d.velocity = turned(c.velocity), d.spin = turned(c.spin);
    f = force<Law>(c, p, 1e-4, here), g = force<Law>(d, p, 1e-4, there);
  }
  CHECK(distance(turned(f.force), g.force) <= 1e-12 * f.force.norm());
  CHECK(distance(turned(f.moment), g.moment) <= 1e-12 * f.moment.norm());
  CHECK(distance(turned(f.conserved), g.conserved) <= 1e-12 * f.conserved.norm() + 1e-15);
}

/// With the two bodies exchanged the force is the opposite: action equals reaction.
template <class Law>
void check_reaction(const typename Law::parameters& p, real overlap) {
  typename Law::memory here{}, there{};
  interaction_force f, g;
  for (int k = 0; k < 10; ++k) {
    contact_kinematics c = contact_at(-overlap), d = c;
    d.normal = -c.normal, d.velocity = -c.velocity, d.spin = -c.spin, d.mean_spin = -c.mean_spin;
    f = force<Law>(c, p, 1e-4, here), g = force<Law>(d, p, 1e-4, there);
  }
  CHECK(distance(f.force, -g.force) <= 1e-12 * f.force.norm());
  CHECK(distance(f.moment, -g.moment) <= 1e-12 * f.moment.norm());
}

/// Beyond its range a composed law that still has the memory of a contact neither pushes nor stores
/// energy, though another law of the scenario may reach farther.
template <class Composed, class Parameters>
void check_range(const Parameters& p, real overlap) {
  auto memory = used_memory<Composed>(p, overlap);
  const real end = range_of<Composed>(p, contact_at(0).radius);
  auto c = contact_at(end * (1 + 1e-9) + 1e-12);
  CHECK(Composed::stored(c, p, memory).normal == 0);
  CHECK(Composed::stored(c, p, memory).kept == 0);
  const interaction_force f = Composed::force(c, p, 1e-4, memory);
  CHECK(f.force == vec3(0, 0, 0));
  CHECK(f.moment == vec3(0, 0, 0));
  // And it has reset the memory of the contact.
  c.velocity = c.spin = vec3(0, 0, 0), c.mean_spin = 0, c.gap = -overlap;
  typename Composed::memory fresh{};
  CHECK(distance(Composed::force(c, p, 1e-4, memory).force,
                 Composed::force(c, p, 1e-4, fresh).force) == 0);
}

/// The stored energy at the end of the range is zero, so that no energy appears when a contact
/// ends.
template <class Law>
void check_end(const typename Law::parameters& p, real overlap) {
  const auto memory = used_memory<Law>(p, overlap);
  const real end = range_of<Law>(p, contact_at(0).radius);
  const real scale = std::abs(Law::stored(contact_at(-overlap), p, memory).normal);
  CHECK(std::abs(Law::stored(contact_at(end - 1e-9 * overlap), p, memory).normal) <= 1e-6 * scale);
}

/// Along the normal the conserved force is the slope of the stored energy.
template <class Law>
void check_gradient(const typename Law::parameters& p, real overlap) {
  const auto memory = used_memory<Law>(p, overlap);
  const real end = range_of<Law>(p, contact_at(0).radius);
  for (const real gap : {-overlap, -0.3 * overlap, 0.2 * end, 0.9 * end}) {
    if (gap >= 0 && end == 0) continue;
    CAPTURE(gap);
    auto c = contact_at(gap);
    const real h = 1e-6 * std::max(overlap, end);
    const auto energy = [&](real at) {
      c.gap = at;
      return Law::stored(c, p, memory).normal;
    };
    const real slope = (energy(gap + h) - energy(gap - h)) / (2 * h);
    c.gap = gap, c.velocity = c.spin = vec3(0, 0, 0), c.mean_spin = 0;
    auto kept = memory;
    const vec3 conserved = force<Law>(c, p, 0, kept).conserved;
    CHECK(conserved.dot(c.normal) == doctest::Approx(-slope).epsilon(1e-5));
  }
}

/// With dt = 0 the memory does not change, and the force is the same again.
template <class Law>
void check_no_time(const typename Law::parameters& p, real overlap) {
  auto memory = used_memory<Law>(p, overlap);
  const auto c = contact_at(-overlap);
  const interaction_force first = force<Law>(c, p, 0, memory);
  const auto before = Law::stored(c, p, memory);
  const interaction_force second = force<Law>(c, p, 0, memory);
  const auto after = Law::stored(c, p, memory);
  CHECK(distance(first.force, second.force) <= 1e-13 * first.force.norm());
  CHECK(after.normal == before.normal);
  CHECK(after.kept == doctest::Approx(before.kept).epsilon(1e-13));
}

/// Two bodies separate and approach on closed paths, sliding and rolling on the way: the work put
/// in is at least the stored energy at the end; and the difference is the loss that the law books,
/// to the order of the step.
template <class Law>
void check_passivity(const typename Law::parameters& p, real overlap) {
  const real end = range_of<Law>(p, contact_at(0).radius);
  const real most = end > 0 ? 1.05 * end : 0.2 * overlap;
  random_stream random(7, 1);
  for (int path = 0; path < 20; ++path) {
    CAPTURE(path);
    const vec3 phase = random.uniform(vec3(0, 0, 0), vec3(6, 6, 6));
    const vec3 size = overlap * random.uniform(vec3(0, 0, 0), vec3(2, 2, 2));
    const int steps = 4000;
    const real period = random.uniform(0.5, 2), dt = period / steps;
    typename Law::memory memory{};
    contact_kinematics c = contact_at(most);
    c.normal = {0, 0, 1}, c.mean_spin = 0, c.step = dt;
    real work = 0, scale = 0;
    for (int k = 0; k < 2 * steps; ++k) {
      const real t = 2 * pi * (k + 0.5) / steps, w = 2 * pi / period;
      const real middle = 0.5 * (most - overlap), swing = 0.5 * (most + overlap);
      c.gap = middle + swing * std::cos(t);
      c.velocity = {size[0] * w * std::cos(t + phase[0]), size[1] * w * std::cos(2 * t + phase[1]),
                    -swing * w * std::sin(t)};
      c.spin = vec3(size[2] * w * std::cos(t + phase[2]), 0, 0) / c.radius;
      const interaction_force f = force<Law>(c, p, dt, memory);
      const real power = f.force.dot(c.velocity) + f.moment.dot(c.spin);
      work -= dt * power, scale += dt * std::abs(power);
    }
    c.gap = most;
    CHECK(work >= -1e-3 * scale);
  }
}

/// All laws, for the law alone and within a composed law.
template <class Law, class Parameters>
void check_law(const Parameters& p, real overlap) {
  static_assert(concepts::interaction_law<Law>);
  static_assert(std::is_trivially_copyable_v<typename Law::memory>);
  static_assert(std::is_trivially_copyable_v<typename Law::parameters>);
  CAPTURE(Law::name);
  CHECK(p == p);
  CHECK_FALSE(p == Parameters{});
  check_frame<Law>(p, overlap);
  check_reaction<Law>(p, overlap);
  check_end<Law>(p, overlap);
  check_gradient<Law>(p, overlap);
  check_no_time<Law>(p, overlap);
  check_passivity<Law>(p, overlap);
  CHECK(Law::longest_step(p, 0.7) > 0);
  CHECK(Law::duration(p, head_on_impact{.mass = 0.7, .radius = 0.4, .speed = 1}) > 0);
}

}  // namespace laws
