// Soft contacts of ellipsoids have the force of Hertz's theory for two curvatures, and adhere up to
// the gap at which the neck of those curvatures tears.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <talus/adhesion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/ellipsoid.hpp>
#include <talus/shape/superellipsoid.hpp>
#include <talus/world/each_contact.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

constexpr real modulus = 1e6, poisson = 0.3;

template <class Shape>
real force_on_plane(const Shape& s, const quat& turn, real height) {
  using scene = scenario<bodies<Shape, plane>, soft_contact<hertz_mindlin>, transport<serial>>;
  serial::link link;
  world<scene> w(link);
  const auto stuff = w.material(
      {.density = 1, .restitution = 0.5, .youngs_modulus = modulus, .poisson_ratio = poisson});
  w.global([&](auto& scope) { scope.add(plane{}, stuff); });
  const auto it = w.add(
      body<Shape>{.shape = s, .position = {0, 0, height}, .material = stuff, .orientation = turn});
  w.step(1e-12);
  return w[it].velocity()[2] * s.volume() / 1e-12;
}
/// The integral of f over all of 0 < u, by trapezoids, for f that falls off as exp(-u) at least.
template <class F>
real half_line(F&& f) {
  const real h = 0.01;
  real sum = f(0.) / 2;
  for (int k = 1; k < 6000; ++k) sum += f(k * h);
  return sum * h;
}
/// The complete elliptic integrals, with sinh u for the tangent of the angle.
struct elliptic_integrals {
  real K = 0, E = 0;

  explicit elliptic_integrals(real k) {
    const auto root = [&](real u) { return std::hypot(1, k * std::sinh(u)); };
    K = half_line([&](real u) { return 1 / root(u); });
    E = half_line([&](real u) { return root(u) / (std::cosh(u) * std::cosh(u)); });
  }
};

}  // namespace

TEST_CASE("an ellipsoid presses on a plane as Hertz's theory of elliptic contacts says") {
  const real stiff = modulus / (1 - poisson * poisson) / 2;  // of two bodies of one material
  const real overlap = 1e-4;
  CHECK(force_on_plane(ellipsoid{{1, 1, 1}}, {1, 0, 0, 0}, 1 - overlap) ==
        doctest::Approx(force_on_plane(sphere{1}, {1, 0, 0, 0}, 1 - overlap)).epsilon(1e-9));
  // Ratios of the axes of the ellipse of contact; those of the radii are up to 1e8.
  for (const real k : {0.8, 0.5, 0.3, 0.1, 0.01, 3e-3, 1e-3, 1e-4, 3.0426e-5}) {
    const real e2 = 1 - k * k;
    const auto [K, E] = elliptic_integrals(k);
    const real long_side = E / (k * k) - K, short_side = K - E;
    const real ratio = long_side / short_side;  // of the radii (Johnson, Contact Mechanics, 4.2)
    const real f1 = std::cbrt(4 / (pi * e2) * std::pow(k, 1.5) * std::sqrt(long_side * short_side));
    const real f2 = 2 / pi * std::sqrt(k) / f1 * K;
    // Radii of curvature a²/c and b²/c below an ellipsoid that stands on the axis c.
    const real b = 1, a = std::sqrt(ratio), c = 1.3;
    const real mean = a * b / c;
    const real wanted = 4. / 3 * stiff * std::sqrt(mean) * std::pow(overlap / f2, 1.5);
    CAPTURE(ratio);
    CHECK(force_on_plane(ellipsoid{{a, b, c}}, rotation({0, 0, 1}, 0.4), c - overlap) ==
          doctest::Approx(wanted).epsilon(1e-7));
    // The same with the axes exchanged: the body stands on its first axis.
    CHECK(force_on_plane(ellipsoid{{c, a, b}}, rotation(vec3(1, 1, 1).normalized(), -2 * pi / 3),
                         c - overlap) == doctest::Approx(wanted).epsilon(1e-7));
  }
}

TEST_CASE("a disc presses on a plane with its sharp rim") {
  // (The radii at the rim are 1 and 3.6e-5.)
  const real force = force_on_plane(ellipsoid{{1, 1, 0.006}}, rotation({0, 1, 0}, pi / 2), 0.9999);
  const real of_ball = force_on_plane(sphere{0.006 * 0.006}, {1, 0, 0, 0}, 0.006 * 0.006 - 1e-4);
  const real of_larger = force_on_plane(sphere{1}, {1, 0, 0, 0}, 0.9999);
  CHECK(force > of_ball);
  CHECK(force < of_larger);
}

TEST_CASE("an adhering ellipsoid tears off where the neck of its flat side tears") {
  using scene = scenario<bodies<ellipsoid, plane>, soft_contact<jkr_adhesion>, transport<serial>>;
  const real work = 1, flat = 5, edge = 0.2 * 0.2;  // radii of curvature
  for (const bool on_edge : {false, true}) {
    CAPTURE(on_edge);
    serial::link link;
    world<scene> w(link);
    // So heavy that the contact does not slow it down.
    const auto stuff = w.material(
        {.density = 1e8, .restitution = 1, .youngs_modulus = modulus, .poisson_ratio = poisson});
    w.interaction(stuff, stuff, jkr_adhesion::given{.work_of_adhesion = work});
    w.global([&](auto& scope) { scope.add(plane{}, stuff); });
    const real half = on_edge ? 1 : 0.2, speed = 0.1, dt = 1e-5;
    const ellipsoid disc{on_edge ? vec3(0.2, 0.2, 1) : vec3(1, 1, 0.2)};
    w.add(body{.shape = disc,
               .position = {0, 0, half - 5e-5},
               .material = stuff,
               .velocity = {0, 0, speed}});
    real least = 0, last = 0, gap = 0;
    for (int k = 0; k < 800; ++k) {
      w.step(dt);
      for_each_contact(w, [&](const loaded_contact& c) {
        last = c.normal_force(), gap = c.gap;
        least = std::min(least, last);
      });
    }
    const real radius = on_edge ? edge : flat;
    const auto p = w.interaction<jkr_adhesion>(stuff, stuff);
    CHECK(least == doctest::Approx(-1.5 * pi * work * radius).epsilon(1e-3));
    CHECK(last == doctest::Approx(-5. / 6 * pi * work * radius).epsilon(0.25));
    CHECK(gap == doctest::Approx(jkr_adhesion::range(p, radius)).epsilon(0.02));
  }
}

TEST_CASE("a superellipsoid presses on a plane with the curvatures of the place that touches") {
  const real overlap = 1e-4;
  const ellipsoid egg{{1, 0.7, 1.3}};
  const quat turn = rotation({1, 2, 0}, 0.8);
  const auto reach = [&](const auto& s) {
    const vec3 down = turn.conjugate() * vec3(0, 0, -1);
    return down.dot(s.support(down));
  };
  CHECK(force_on_plane(superellipsoid{egg.radii}, turn, reach(egg) - overlap) ==
        doctest::Approx(force_on_plane(egg, turn, reach(egg) - overlap)).epsilon(1e-9));
  // On its edge, a blocky one is sharper; on its flat top the radius counts as 10 times its reach.
  const superellipsoid block{egg.radii, 6, 6};
  CHECK(force_on_plane(block, turn, reach(block) - overlap) <
        0.9 * force_on_plane(egg, turn, reach(egg) - overlap));
  const real flat = 10 * block.bounding_radius();
  CHECK(force_on_plane(block, {1, 0, 0, 0}, 1.3 - overlap) ==
        doctest::Approx(4. / 3 * modulus / (1 - poisson * poisson) / 2 * std::sqrt(flat) *
                        std::pow(overlap, 1.5))
            .epsilon(5e-3));
}
