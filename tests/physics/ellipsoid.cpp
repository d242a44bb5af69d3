// An ellipsoid on a plane rocks with the period of the closed form, and keeps its energy.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/parallel/serial.hpp>
#include <talus/scenario/scenario.hpp>
#include <talus/shape/ellipsoid.hpp>
#include <talus/shape/frame.hpp>
#include <talus/shape/plane.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

struct rocking {
  real period = 0, energy = 0;  ///< largest change of the energy, of weight times height
};

/// Small swings about the y axis: the centre of curvature at the contact lies at a²/c above the
/// ground, so that the square of the frequency is g (a²/c - c) / ((a² + c²) / 5 + c²).
rocking rock(const ellipsoid& e, real tilt, int steps_of_period, int periods) {
  using scene = scenario<bodies<ellipsoid, plane>, transport<serial>>;
  serial::link link;
  world<scene> w(link);
  const real g = 9.81, a = e.radii[0], c = e.radii[2];
  w.gravity({0, 0, -g});
  const auto stuff = w.material({.density = 1, .restitution = 0, .friction = 1});
  w.global([&](auto& scope) { scope.add(plane{}, stuff); });
  const quat turn = rotation({0, 1, 0}, tilt);
  const vec3 down = turn.conjugate() * vec3(0, 0, -1);
  const real height = down.dot(e.support(down));
  const auto egg =
      w.add(body{.shape = e, .position = {0, 0, height}, .material = stuff, .orientation = turn});
  const real wanted = 2 * pi * std::sqrt(((a * a + c * c) / 5 + c * c) / (g * (a * a / c - c)));
  const real dt = wanted / steps_of_period;
  const auto angle = [&] {
    const vec3 axis = w[egg].orientation() * vec3(0, 0, 1);
    return std::atan2(axis[0], axis[2]);
  };
  const vec3 inertia = e.inertia();
  const auto energy = [&] {
    const vec3 spin = w[egg].orientation().conjugate() * w[egg].angular_velocity();
    return (0.5 * w[egg].velocity().squaredNorm() + 0.5 * spin.dot(inertia.cwiseProduct(spin)) +
            g * w[egg].position()[2]) /
           (g * c);
  };
  rocking found;
  const real start = energy();
  real before = angle(), first = -1, last = -1;
  int crossings = 0;
  for (int k = 0; k < periods * steps_of_period; ++k) {
    w.step(dt);
    const real now = angle();
    if (before > 0 && now <= 0) {
      last = (k + before / (before - now)) * dt;
      if (first < 0) first = last;
      ++crossings;
    }
    before = now;
    found.energy = std::max(found.energy, std::abs(energy() - start));
  }
  found.period = (last - first) / (crossings - 1) / wanted;
  return found;
}

}  // namespace

TEST_CASE("an ellipsoid on a plane rocks with the period of the closed form") {
  for (const ellipsoid& e : {ellipsoid{{0.5, 0.4, 0.3}}, ellipsoid{{2, 1, 1}}}) {
    const rocking r = rock(e, 0.005, 2000, 10);
    MESSAGE("period over the closed form ", r.period - 1, ", energy ", r.energy);
    CHECK(std::abs(r.period - 1) < 1e-4);
    CHECK(r.energy < 1e-6);
  }
}
