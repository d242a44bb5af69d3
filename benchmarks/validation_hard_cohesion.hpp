#pragma once
/// \file
/// Hard contacts that stick: the weight that a contact bears, and the slope on which a block rests.
#include <cmath>
#include <string>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>

#include "validation.hpp"

namespace validation {

namespace hard_cohesion_cases {

using scene = talus::scenario<talus::bodies<talus::sphere, talus::box, talus::plane>,
                              talus::hard_contact<talus::coulomb_friction, talus::normal_cohesion>,
                              talus::transport<talus::serial>>;
inline constexpr double dt = 1e-2, pull = 3;

/// The weight, in units of the cohesion, at which a body of mass 1 falls from a ceiling.
template <class Shape>
double falls_at(const Shape& shape, double height, const effort& how) {
  using namespace talus;
  serial::link link;
  world<scene> w(link);
  const auto m = w.material({.density = 1 / shape.volume(), .friction = 0.5});
  w.material_pair(m, m, {.friction = 0.5, .cohesion = pull});
  w.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, -1}}, m); });
  const auto b = w.add(body{.shape = shape, .position = {0, 0, -height}, .material = m});
  const int steps = how.quick ? 2000 : 20000;
  for (int k = 0; k < steps; ++k) {
    const double load = 0.9 + 0.2 * k / steps;
    w.gravity({0, 0, -load * pull});
    w.step(dt);
    if (w[b].position()[2] < -height - 1e-3) return load;
  }
  return 0;
}

/// Tangent of the slope on which a block of mass 1 begins to slide, in gravity 10.
inline double slides_at(double friction, double from, double to, const effort& how) {
  using namespace talus;
  serial::link link;
  world<scene> w(link);
  const auto m = w.material({.density = 1 / 0.5, .friction = friction});
  w.material_pair(m, m, {.friction = friction, .cohesion = pull});
  w.global([&](auto& scope) { scope.add(plane{}, m); });
  const auto b = w.add(body{.shape = box{{1, 1, 0.5}}, .position = {0, 0, 0.25}, .material = m});
  const int steps = how.quick ? 2000 : 20000;
  for (int k = 0; k < steps; ++k) {
    const double angle = from + (to - from) * k / steps;
    w.gravity({10 * std::sin(angle), 0, -10 * std::cos(angle)});
    w.step(dt);
    if (w[b].position()[0] > 1e-3) return std::tan(angle);
  }
  return 0;
}

}  // namespace hard_cohesion_cases

inline void hard_cohesion(report& out, const effort& how) {
  using namespace hard_cohesion_cases;
  const std::string source = "Coulomb's law with cohesion: p_n >= -F_c dt";
  out.push_back({"hard_cohesion/sphere below a ceiling", "weight over cohesion", "1", 1,
                 falls_at(talus::sphere{0.5}, 0.5, how), 0.01, source});
  out.push_back({"hard_cohesion/box below a ceiling", "weight over cohesion", "1", 1,
                 falls_at(talus::box{{1, 1, 0.5}}, 0.25, how), 0.01, source});
  for (const double friction : {0.3, 0.6}) {
    // sin = mu (cos + F_c / (m g))
    const double c = pull / 10, lean = std::atan(friction);
    const double angle = lean + std::asin(friction * c * std::cos(lean));
    out.push_back(
        {"hard_cohesion/block on a slope, friction " + std::string(friction < 0.5 ? "0.3" : "0.6"),
         "tangent of the slope", "1", std::tan(angle),
         slides_at(friction, 0.95 * angle, 1.1 * angle, how), 0.01 * std::tan(angle),
         "|p_t| <= mu (p_n + F_c dt)"});
  }
}

}  // namespace validation
