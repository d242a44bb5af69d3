// Contacts of ellipsoids that are computed several at a time: the bits of those of single pairs.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "solids.hpp"
#include "talus/detect/ellipsoid_batch.hpp"
#include "talus/detect/pairs/ellipsoid_any.hpp"

using namespace talus::detail;
using namespace solids;

namespace {

struct posed {
  ellipsoid shape;
  pose at;
};
/// From needles to discs and balls, of sizes that differ by up to a hundred.
posed random_posed(generator& random) {
  const real size = std::pow(10, random(-2, 0)), thin = random(0, 1) < 0.2 ? 0.02 : 0.4;
  const auto radius = [&] { return random(0, 1) < 0.1 ? size : size * random(thin, 1); };
  return {{{radius(), radius(), radius()}}, {random.point(1), random.turn()}};
}
contacts single(const posed& a, const posed& b, real margin) {
  contacts found;
  collide(a.shape, a.at, b.shape, b.at, margin,
          [&](const contact_geometry& c) { found.push_back(c); });
  return found;
}

}  // namespace

TEST_CASE("contacts of several pairs of ellipsoids have the bits of single ones") {
  constexpr unsigned capacity = ellipsoid_batch<real>::capacity;
  std::size_t met = 0, beyond = 0, uncertain = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const unsigned count = 1 + seed % capacity;
    std::vector<posed> a, b;
    std::vector<ellipsoid_place<real>> in_a, in_b;
    std::vector<real> margin;
    for (unsigned k = 0; k < count; ++k) {
      a.push_back(random_posed(random)), b.push_back(random_posed(random));
      // Most pairs nearly touch along the line of their centres; some have one centre.
      const vec3 d = random.turn() * vec3(0, 0, 1);
      const auto way = [&](const posed& p) {
        return d.dot(p.at.orientation * p.shape.support(p.at.orientation.conjugate() * d));
      };
      const real away = random(0, 1) < 0.02 ? 0 : random(0.95, 1.1) * (way(a[k]) + way(b[k]));
      b[k].at.position = a[k].at.position + away * d;
      margin.push_back(random(0, 0.1) * a[k].shape.inner_radius());
    }
    for (unsigned k = 0; k < count; ++k) {
      in_a.push_back(place_of<real>(a[k].shape, a[k].at, 0));
      in_b.push_back(place_of<real>(b[k].shape, b[k].at, 0));
    }
    ellipsoid_batch<real> batch;
    for (unsigned k = 0; k < count; ++k) batch.set(k, in_a[k], in_b[k], margin[k]);
    const unsigned bits = batch.search(count);
    for (unsigned k = 0; k < count; ++k) {
      const contacts expected = single(a[k], b[k], margin[k]);
      if (batch.uncertain() >> k & 1u) {
        CHECK_FALSE((bits >> k & 1u));
        ++uncertain;
        continue;
      }
      const unsigned touches = bits >> k & 1u;
      REQUIRE(touches == expected.size());
      if (expected.empty()) {
        ++beyond;
        continue;
      }
      const contact_geometry c = batch.contact(k, in_a[k].position);
      CHECK(c.gap == expected[0].gap);
      CHECK(c.normal == expected[0].normal);
      CHECK(c.point == expected[0].point);
      ++met;
    }
  }
  MESSAGE(met << " touch, " << beyond << " are apart, " << uncertain
              << " are left to single pairs");
  CHECK(met > 1000);
  CHECK(beyond > 1000);
  CHECK(uncertain > 50);
}
