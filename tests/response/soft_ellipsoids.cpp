// Soft contacts of ellipsoids have the force of Hertz's theory for two curvatures.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/parallel/serial.hpp>
#include <talus/shape/ellipsoid.hpp>
#include <talus/shape/superellipsoid.hpp>
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
/// The integral of f over a quarter of a circle.
template <class F>
real quarter(F&& f) {
  real sum = 0;
  const int n = 2000;
  for (int k = 0; k < n; ++k) sum += f((k + 0.5) * pi / 2 / n);
  return sum * pi / 2 / n;
}

}  // namespace

TEST_CASE("an ellipsoid presses on a plane as Hertz's theory of elliptic contacts says") {
  const real stiff = modulus / (1 - poisson * poisson) / 2;  // of two bodies of one material
  const real overlap = 1e-4;
  CHECK(force_on_plane(ellipsoid{{1, 1, 1}}, {1, 0, 0, 0}, 1 - overlap) ==
        doctest::Approx(force_on_plane(sphere{1}, {1, 0, 0, 0}, 1 - overlap)).epsilon(1e-9));
  for (const real k : {0.8, 0.5, 0.3}) {  // ratio of the axes of the ellipse of contact
    const real e2 = 1 - k * k;
    const real K =
        quarter([&](real x) { return 1 / std::sqrt(1 - e2 * std::sin(x) * std::sin(x)); });
    const real E = quarter([&](real x) { return std::sqrt(1 - e2 * std::sin(x) * std::sin(x)); });
    const real long_side = E / (k * k) - K, short_side = K - E;
    const real ratio = long_side / short_side;  // of the radii (Johnson, Contact Mechanics, 4.2)
    const real f1 = std::cbrt(4 / (pi * e2) * std::pow(k, 1.5) * std::sqrt(long_side * short_side));
    const real f2 = 2 / pi * std::sqrt(k) / f1 * K;
    // Radii of curvature a²/c and b²/c below an ellipsoid that stands on the axis c.
    const real b = 1, a = std::sqrt(ratio), c = 1.3;
    const real mean = a * b / c;
    const real wanted = 4. / 3 * stiff * std::sqrt(mean) * std::pow(overlap / f2, 1.5);
    CHECK(force_on_plane(ellipsoid{{a, b, c}}, rotation({0, 0, 1}, 0.4), c - overlap) ==
          doctest::Approx(wanted).epsilon(5e-3));
    // Lying on another side, with the same two radii in other places.
    CHECK(force_on_plane(ellipsoid{{c, a, b}}, rotation(vec3(1, 1, 1).normalized(), -2 * pi / 3),
                         c - overlap) == doctest::Approx(wanted).epsilon(5e-3));
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
