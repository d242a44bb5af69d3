// A superellipsoid on a plane rocks with the period of the closed form, and keeps its energy.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/parallel/serial.hpp>
#include <talus/scenario/scenario.hpp>
#include <talus/shape/frame.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/superellipsoid.hpp>
#include <talus/world/world.hpp>

using namespace talus;

TEST_CASE("a superellipsoid on a plane rocks with the period of the closed form") {
  // With n1 = 2, all sections through the z axis are ellipses, whatever n2 is: swings about the y
  // axis are those of an ellipsoid, with the inertia of the superellipsoid.
  using scene = scenario<bodies<superellipsoid, plane>, transport<serial>>;
  const superellipsoid s{{0.5, 0.4, 0.3}, 2, 4};
  serial::link link;
  world<scene> w(link);
  const real g = 9.81, a = s.radii[0], c = s.radii[2];
  w.gravity({0, 0, -g});
  const auto stuff = w.material({.density = 1, .restitution = 0, .friction = 1});
  w.global([&](auto& scope) { scope.add(plane{}, stuff); });
  const quat turn = rotation({0, 1, 0}, 0.005);
  const vec3 down = turn.conjugate() * vec3(0, 0, -1);
  const auto egg = w.add(body{.shape = s,
                              .position = {0, 0, down.dot(s.support(down))},
                              .material = stuff,
                              .orientation = turn});
  const vec3 inertia = s.inertia();
  const real wanted = 2 * pi * std::sqrt((inertia[1] + c * c) / (g * (a * a / c - c)));
  const real dt = wanted / 2000;
  const auto angle = [&] {
    const vec3 axis = w[egg].orientation() * vec3(0, 0, 1);
    return std::atan2(axis[0], axis[2]);
  };
  const auto energy = [&] {
    const vec3 spin = w[egg].orientation().conjugate() * w[egg].angular_velocity();
    return (0.5 * w[egg].velocity().squaredNorm() + 0.5 * spin.dot(inertia.cwiseProduct(spin)) +
            g * w[egg].position()[2]) /
           (g * c);
  };
  const real start = energy();
  real before = angle(), first = -1, last = -1, drift = 0;
  int crossings = 0;
  for (int k = 0; k < 20000; ++k) {
    w.step(dt);
    const real now = angle();
    if (before > 0 && now <= 0) {
      last = (k + before / (before - now)) * dt;
      if (first < 0) first = last;
      ++crossings;
    }
    before = now;
    drift = std::max(drift, std::abs(energy() - start));
  }
  const real period = (last - first) / (crossings - 1) / wanted;
  MESSAGE("period over the closed form ", period - 1, ", energy ", drift);
  CHECK(std::abs(period - 1) < 1e-4);
  CHECK(drift < 1e-6);
}
