// Contacts of spheres that are computed eight at a time: the bits of those of single pairs.
#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "talus/detect/pairs/sphere_sphere.hpp"
#include "talus/detect/sphere_batch.hpp"

using namespace talus;
using namespace talus::detail;

namespace {

constexpr real gravity = 9.81, dt = 1.0 / 240;

class cloud {
 public:
  explicit cloud(unsigned seed) : random_(seed) {}
  real between(real low, real high) { return std::uniform_real_distribution<>(low, high)(random_); }
  vec3 vector(real size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  moving_sphere sphere() {
    const real radius = between(0.4, 0.5);
    return {vector(0.6), radius * between(1, 1.2), vector(1), radius, vector(3), system_id{}};
  }

 private:
  std::mt19937 random_;
};

/// The same as a single pair, as the maker of contacts computes it.
struct single {
  bool met = false;
  contact_geometry at{};
  vec3 velocity{0, 0, 0};
  real arm_a = 0, arm_b = 0;

  single(const moving_sphere& a, const moving_sphere& b, real margin, real slack) {
    const pose at_a{a.position, quat{1, 0, 0, 0}}, at_b{b.position, quat{1, 0, 0, 0}};
    collide(sphere{a.radius}, at_a, sphere{b.radius}, at_b, margin, [&](const contact_geometry& g) {
      const vec3 to_a = g.point - a.position, to_b = g.point - b.position;
      velocity = a.velocity + a.spin.cross(to_a) - (b.velocity + b.spin.cross(to_b));
      const real closing = g.normal.dot(velocity) * dt - 2 * gravity * dt * dt;
      if (g.gap > slack && g.gap + closing > slack) return;
      met = true, at = g;
      arm_a = -g.normal.dot(to_a), arm_b = g.normal.dot(to_b);
    });
  }
};

}  // namespace

TEST_CASE("contacts of several pairs have the bits of single ones") {
  cloud random(1);
  std::size_t met = 0, apart = 0;
  for (int round = 0; round < 500; ++round) {
    const unsigned count = 1 + static_cast<unsigned>(round) % sphere_batch::capacity;
    std::vector<moving_sphere> a, b;
    std::vector<real> margins, slacks;
    sphere_batch batch;
    for (unsigned k = 0; k < count; ++k) {
      a.push_back(random.sphere()), b.push_back(random.sphere());
      if (round % 50 == 0) b[k].position = a[k].position;  // concentric
      margins.push_back(random.between(0, 0.1)), slacks.push_back(random.between(0, 0.02));
    }
    for (unsigned k = 0; k < count; ++k) batch.set(k, a[k], b[k], margins[k], slacks[k]);
    const unsigned bits = batch.collide(count, gravity, dt);
    CHECK((bits >> count) == 0u);
    for (unsigned k = 0; k < count; ++k) {
      const single one(a[k], b[k], margins[k], slacks[k]);
      CHECK((bits >> k & 1u) == (one.met ? 1u : 0u));
      ++(one.met ? met : apart);
      if (!one.met) continue;
      CHECK(lane(batch.normal, k) == one.at.normal);
      CHECK(batch.gap[k] == one.at.gap);
      CHECK(lane(batch.velocity, k) == one.velocity);
      CHECK(batch.approach[k] == one.at.normal.dot(one.velocity));
      CHECK(batch.arm_a[k] == one.arm_a);
      CHECK(batch.arm_b[k] == one.arm_b);
    }
  }
  CHECK(met > 100);
  CHECK(apart > 100);
}
