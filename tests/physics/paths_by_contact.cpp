// Whether smooth bodies meet in a step, decided by their velocities at the contact: never against
// the search along their paths.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <talus/parallel/serial.hpp>
#include <talus/shape/ellipsoid.hpp>
#include <talus/world/world.hpp>

using namespace talus;
using talus::detail::path;

namespace {

using scene = scenario<bodies<ellipsoid, sphere>, transport<serial>>;

class dice {
 public:
  explicit dice(std::uint64_t seed) : engine_(seed) {}
  real operator()(real low, real high) {
    return std::uniform_real_distribution<real>(low, high)(engine_);
  }
  vec3 vector(real size) {
    const real x = (*this)(-size, size), y = (*this)(-size, size), z = (*this)(-size, size);
    return {x, y, z};
  }

 private:
  std::mt19937_64 engine_;
};

struct decided {
  int meet = 0, pass = 0, unknown = 0;
};

/// Pairs of which one is nearly touched by the other, at speeds from a creep to a fling.
template <class B>
decided compare(std::uint64_t first_seed, const B& other) {
  decided sum;
  for (std::uint64_t seed = first_seed; seed < first_seed + 400; ++seed) {
    INFO("seed " << seed);
    dice random(seed);
    const auto vector = [&](real size) { return random.vector(size); };
    const auto turn = [&] {
      return rotation(vec3{random(-1, 1), random(-1, 1), 1.1}.normalized(), random(0, 3));
    };
    serial::link link;
    world<scene> w(link);
    w.material({.density = 1});
    w.gravity({0, 0, -9.81});
    const real speed = std::pow(10, random(-4, 0));
    const ellipsoid egg{{random(0.2, 0.5), random(0.2, 0.5), random(0.3, 0.6)}};
    const pose at{{0, 0, 0}, turn()};
    pose there{vec3{random(-1, 1), random(-1, 1), 1.1}.normalized() * 3, turn()};
    const auto each_contact = [&](real margin, auto&& take) {
      collide_pair(egg, at, other, there, margin, take);
    };
    // To a gap below the slack, above that at which they touch.
    const real gap = egg.bounding_radius() * std::pow(10, random(-3.7, -2));
    each_contact(10,
                 [&](const contact_geometry& g) { there.position += (g.gap - gap) * g.normal; });
    each_contact(10,
                 [&](const contact_geometry& g) { there.position += (g.gap - gap) * g.normal; });
    w.add(body<ellipsoid>{.shape = egg,
                          .position = at.position,
                          .velocity = vector(speed),
                          .angular_velocity = vector(3 * speed),
                          .orientation = at.orientation});
    w.add(body<B>{.shape = other,
                  .position = there.position,
                  .velocity = vector(speed),
                  .angular_velocity = vector(3 * speed),
                  .orientation = there.orientation});
    auto& s = talus::detail::state_of(w);
    s.dt = 1.0 / 240;
    constexpr bool alike = std::is_same_v<B, ellipsoid>;
    const auto& a = s.of<ellipsoid>().movable;
    const auto& b = s.of<B>().movable;
    const std::size_t j = alike ? 1 : 0;
    const talus::detail::pair_motion<scene, ellipsoid, B, true> motion(s, a, b);
    each_contact(0.1, [&](const contact_geometry& g) {
      const real slack = 0.02 * egg.bounding_radius();
      const path found = motion.path_by_contact(0, j, a.position[0], b.position[j], slack, g);
      const bool meet = motion.meet_on_paths(0, j, a.position[0], b.position[j], slack);
      ++(found == path::meet ? sum.meet : found == path::pass ? sum.pass : sum.unknown);
      if (found != path::unknown) CHECK((found == path::meet) == meet);
    });
  }
  return sum;
}

void check(const decided& sum) {
  MESSAGE(sum.meet << " meet, " << sum.pass << " pass, " << sum.unknown << " are searched");
  CHECK(sum.meet > 10);
  CHECK(sum.pass > 100);
}

}  // namespace

TEST_CASE("the velocities at a contact of ellipsoids decide as the search along their paths") {
  check(compare(1, ellipsoid{{0.3, 0.4, 0.6}}));
}
TEST_CASE("so do those at a contact of an ellipsoid and a ball") {
  check(compare(1001, sphere{0.4}));
}
// (The monitor, because contacts of spheres that nothing else concerns are kept.)
TEST_CASE("balls that spin pass and meet each other far from the origin as in it") {
  using balls = scenario<bodies<sphere>, transport<serial>, features<penetration_monitor>>;
  int passed = 0, met = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    INFO("seed " << seed);
    dice random(seed);
    const auto vector = [&](real size) { return random.vector(size); };
    const real dt = 1.0 / 64, radius = 0.5;
    const vec3 d = vector(1).normalized(), spin_a = vector(0.5), spin_b = vector(0.5);
    // They close their gap up to four times.
    const real gap = radius * std::exp(random(-8, -4));
    vec3 v = vector(1);
    v -= (v.dot(d) + random(0, 4) * gap / dt) * d;
    const auto change = [&](const vec3& from) {
      serial::link link;
      world<balls> w(link);
      w.material({.density = 1, .restitution = 0});
      const auto a = w.add(body<sphere>{
          .shape = {radius}, .position = from, .velocity = v, .angular_velocity = spin_a});
      w.add(body<sphere>{.shape = {radius},
                         .position = from - (2 * radius + gap) * d,
                         .angular_velocity = spin_b});
      w.step(dt);
      return vec3(w[a].velocity() - v);
    };
    const vec3 here = change({0, 0, 0}), there = change({64, -32, 16});
    CHECK((here - there).norm() < 1e-10);
    ++(here.norm() > 1e-9 ? met : passed);
  }
  MESSAGE(met << " meet, " << passed << " pass");
  CHECK(met > 50);
  CHECK(passed > 50);
}
