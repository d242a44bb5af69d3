// timeout: 300
// Capsules, cylinders, polyhedra and unions: they lie and stand still, fall and come to rest
// without gaining energy, and rotate freely according to their inertia.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/frame.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;
using compound = union_of<sphere, box, capsule>;
using mixture = scenario<bodies<sphere, box, capsule, cylinder, convex_polyhedron, compound, plane>,
                         transport<serial>>;

namespace {

constexpr real g = 9.81, dt = 1.0 / 240;

convex_polyhedron block(const vec3& size) {
  std::vector<vec3> corners;
  for (unsigned c = 0; c < 8; ++c)
    corners.push_back(size.cwiseProduct(vec3(c & 1u, c >> 1 & 1u, c >> 2)));
  return convex_polyhedron(corners);
}
/// Edges of 1, standing on its face z = 0.
convex_polyhedron tetrahedron() {
  const real h = std::sqrt(2 / 3.), r = 1 / std::sqrt(3.);
  return convex_polyhedron({{r, 0, 0}, {-r / 2, 0.5, 0}, {-r / 2, -0.5, 0}, {0, 0, h}});
}
/// An L that stands on its foot, which reaches from -0.5 to 1.5 in x.
compound ell() {
  return compound({{.shape = box{{2, 1, 0.5}}, .at = {{0.5, 0, 0.25}}},
                   {.shape = box{{1, 1, 2}}, .at = {{0, 0, 1.5}}}});
}
const quat lying = rotation({0, 1, 0}, pi / 2);

struct scene {
  serial::link link;
  world<mixture> w{link};

  scene() {
    w.material({.density = 1, .restitution = 0, .friction = 0.5});
    w.gravity({0, 0, -g});
    w.global([&](auto& s) { s.add(plane{}, {}); });
  }
  template <class Shape>
  auto put(const Shape& s, const pose& at) {
    return w.add(body<Shape>{.shape = s, .position = at.position, .orientation = at.orientation});
  }
  void run(real time) {
    for (int k = 0, n = static_cast<int>(std::lround(time / dt)); k < n; ++k) w.step(dt);
  }
  real energy() {
    const auto m = measure_motion(w);
    return m.kinetic_energy + m.potential_energy;
  }
};

/// Stays at its position for five seconds.
template <class Shape>
void check_rest(const char* name, const Shape& s, const pose& at) {
  INFO(std::string(name));
  scene here;
  const auto h = here.put(s, at);
  here.run(5);
  const auto b = here.w[h];
  const real way = (b.position() - at.position).norm();
  const real turned = std::abs(b.orientation().angularDistance(at.orientation));
  const penetration p = measure_penetration(here.w);
  MESSAGE(std::string(name), ": moved ", way, ", turned ", turned, ", overlap ", p.max, ", speed ",
          b.velocity().norm());
  CHECK(way < 1e-4);
  CHECK(turned < 1e-3);
  CHECK(p.max < 1e-3);
  CHECK(b.velocity().norm() < 1e-6);
  CHECK(b.angular_velocity().norm() < 1e-6);
}

}  // namespace

TEST_CASE("bodies at rest on a plane stay at rest for 5 s") {
  check_rest("standing cylinder", cylinder{0.5, 2}, {{0, 0, 1}});
  check_rest("lying cylinder", cylinder{0.5, 2}, {{0, 0, 0.5}, lying});
  check_rest("coin", cylinder{0.5, 0.05}, {{0, 0, 0.025}});
  check_rest("lying capsule", capsule{0.5, 2}, {{0, 0, 0.5}, lying});
  check_rest("tetrahedron", tetrahedron(), placed(tetrahedron()));
  check_rest("cube", block({1, 1, 1}), placed(block({1, 1, 1})));
  const quat turn = rotation({0, 0, 1}, 0.3);
  check_rest(
      "wedge",
      convex_polyhedron({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}, {0, 0, 1}, {0, 1, 1}}),
      placed(convex_polyhedron({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}, {0, 0, 1}, {0, 1, 1}}),
             {{1, 2, 0}, turn}));
  check_rest("L", ell(), placed(ell(), {{0, 0, 0}, turn}));
}

TEST_CASE("stacks of unlike bodies stand for 5 s") {
  scene s;
  // At x = 0: slab, standing cylinder, slab, lying capsule. At x = 5: two lying cylinders side by
  // side, a slab across them. At x = 10: polyhedra on each other.
  s.put(box{{2, 2, 0.5}}, {{0, 0, 0.25}});
  s.put(cylinder{0.6, 1}, {{0, 0, 1}});
  s.put(box{{2, 2, 0.5}}, {{0.1, 0, 1.75}});
  s.put(capsule{0.4, 1}, {{0, 0, 2.4}, lying});
  const quat along_y = rotation({1, 0, 0}, pi / 2);
  s.put(cylinder{0.4, 2}, {{4.5, 0, 0.4}, along_y});
  s.put(cylinder{0.4, 2}, {{5.5, 0, 0.4}, along_y});
  s.put(block({2, 2, 0.3}), placed(block({2, 2, 0.3}), {{4, -1, 0.8}}));
  s.put(block({1, 1, 1}), placed(block({1, 1, 1}), {{9.5, -0.5, 0}}));
  s.put(block({0.8, 0.8, 1}), placed(block({0.8, 0.8, 1}), {{9.6, -0.4, 1}}));
  s.put(tetrahedron(), placed(tetrahedron(), {{10, 0, 2}}));
  std::vector<std::pair<vec3, quat>> before;
  s.w.for_each_local([&](const auto& b) { before.emplace_back(b.position(), b.orientation()); });
  s.run(5);
  std::size_t k = 0;
  s.w.for_each_local([&](const auto& b) {
    INFO("body " << k << ", a " << std::string(b.shape().name));
    CHECK((b.position() - before[k].first).norm() < 2e-3);
    CHECK(b.orientation().angularDistance(before[k].second) < 2e-3);
    CHECK(b.velocity().norm() < 1e-4);
    ++k;
  });
  CHECK(measure_penetration(s.w).max < 1e-3);
}

TEST_CASE("a dropped handful of mixed shapes comes to rest without gaining energy or sinking") {
  scene s;
  // A pit, so that nothing rolls away.
  s.w.global([&](auto& scope) {
    for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
      scope.add(plane{.normal = n, .offset = -2.5}, {});
  });
  random_stream random(11, 0);
  auto next_pose = [&, k = 0]() mutable {
    const pose p{{-1.5 + 1.5 * (k % 3), -1.5 + 1.5 * (k / 3 % 3), 1.5 + 1.6 * (k / 9)},
                 random.rotation()};
    ++k;
    return p;
  };
  const compound dumbbell({{.shape = sphere{0.35}, .at = {{0, 0, -0.4}}},
                           {.shape = capsule{0.15, 0.8}},
                           {.shape = box{{0.5, 0.5, 0.3}}, .at = {{0, 0, 0.5}}}});
  const convex_polyhedron grain({{0.5, 0, 0},
                                 {-0.4, 0.3, 0},
                                 {-0.3, -0.4, 0.1},
                                 {0, 0, 0.6},
                                 {0.1, 0.2, -0.5},
                                 {0.3, -0.3, 0.4},
                                 {-0.2, 0.4, 0.4}});
  for (int round = 0; round < 6; ++round) {
    s.put(sphere{0.4}, next_pose());
    s.put(box{{0.6, 0.8, 0.5}}, next_pose());
    s.put(capsule{0.25, 0.7}, next_pose());
    s.put(cylinder{0.4, 0.5}, next_pose());
    s.put(cylinder{0.25, 0.9}, next_pose());
    s.put(grain, next_pose());
    s.put(block({0.7, 0.6, 0.5}), next_pose());
    s.put(tetrahedron(), next_pose());
    s.put(dumbbell, next_pose());
  }
  const real start = s.energy();
  real before = start, most = 0, gained = 0;
  for (int k = 0; k < 240 * 8; ++k) {
    s.w.step(dt);
    if (k % 4 != 3) continue;
    const real now = s.energy();
    gained = std::max(gained, now - before);
    before = now;
    if (k % 40 == 39) most = std::max(most, measure_penetration(s.w).max);
  }
  const auto m = measure_motion(s.w);
  const auto p = measure_penetration(s.w);
  MESSAGE(m.bodies, " bodies, energy ", start, " -> ", before, ", largest gain in 4 steps ", gained,
          ", overlap ", p.max, " (mean ", p.mean, "), while falling ", most, ", speed ",
          m.max_speed, ", kinetic energy ", m.kinetic_energy);
  CHECK(gained < 1e-3 * start);
  CHECK(before < 0.6 * start);
  CHECK(m.kinetic_energy < 1e-3 * start);
  CHECK(p.max < 0.02);
  CHECK(p.mean < 2e-3);
  CHECK(most < 0.1);
  s.w.for_each_local([&](const auto& b) {
    CHECK(b.position()[2] > 0.1);
    CHECK(std::abs(b.position()[0]) < 2.5);
    CHECK(std::abs(b.position()[1]) < 2.5);
  });
}

TEST_CASE("a union of two spheres falls and spins freely as its inertia says") {
  serial::link link;
  using pair = union_of<sphere>;
  world<scenario<bodies<pair>, transport<serial>>> w(link);
  w.material({.density = 2});
  w.gravity({0, 0, -g});
  // Given upright, 3 from centre to centre, at any place.
  const pair dumbbell(
      {{.shape = sphere{1}, .at = {{7, 7, 7}}}, {.shape = sphere{1}, .at = {{7, 7, 10}}}});
  const real m = 2 * 8 * pi / 3, across = 0.4 + 2.25, along = 0.4;
  CHECK((dumbbell.inertia() - vec3(across, across, along)).norm() < 1e-14);
  const auto h = w.add(body<pair>{.shape = dumbbell,
                                  .position = {0, 0, 0},
                                  .velocity = {1, 0, 2},
                                  .angular_velocity = {1, 0, 3}});
  CHECK(w[h].mass() == doctest::Approx(m));
  CHECK((w[h].inertia() - m * vec3(across, across, along)).norm() < 1e-12);
  const real step = 1e-3, time = 2;
  for (int k = 0; k < 2000; ++k) w.step(step);
  // The axis precesses about the angular momentum, which keeps its direction, at |L| / I_across.
  const vec3 spin = m * vec3(across * 1, 0, along * 3);
  const vec3 expected = rotation(spin, spin.norm() / (m * across) * time) * vec3(0, 0, 1);
  const vec3 axis = w[h].orientation() * vec3(0, 0, 1);
  MESSAGE("axis off by ", (axis - expected).norm());
  CHECK((axis - expected).norm() < 1e-5);
  const vec3 w1 = w[h].angular_velocity();
  CHECK(axis.dot(w1) == doctest::Approx(3).epsilon(1e-6));
  const vec3 fallen = vec3(1, 0, 2) * time - vec3(0, 0, 0.5 * g * time * (time + step));
  CHECK((w[h].position() - fallen).norm() < 1e-9);
}
