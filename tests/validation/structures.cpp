// long
// timeout: 300
// Structures that stand or fall by a closed form, at the default settings: overhanging blocks,
// leaning cards, tall boxes, and the wave that runs through dominoes. (Arches: arches.cpp;
// more on four ranks, and arches of little friction: structures_long.cpp.)
#include <doctest/doctest.h>

#include "structures.hpp"

using namespace talus;
using namespace talus::validation;

TEST_CASE(
    "blocks overhang by L/2 (1 + 1/2 + ... + 1/n): they stand at 0.99 and fall at 1.01 of it") {
  check_overhang(1);
}

TEST_CASE(
    "two leaning cards slide on a floor of mu = tan(alpha)/2, within 2 %; a house of cards "
    "stands") {
  for (const int ranks : {1, 4}) {
    for (const real alpha : {15 * degree, 25 * degree})
      for (const real part : {0.98, 1.02})
        check_stands(
            "cards" + on(ranks),
            fmt::format("{:.0f} degrees, {:.2f} of the critical friction", alpha / degree, part),
            part > 1,
            watch(ranks, part > 1 ? 3 : 5,
                  [&](auto& w) { cards::pair(w, alpha, part * cards::critical(alpha)); }),
            1);
    check_stands("cards" + on(ranks), "a house of seven", true,
                 watch(ranks, 3, [](auto& w) { cards::house(w, 20 * degree, 0.6); }), 1);
  }
}

TEST_CASE("a tall box on an incline slides, tips or stays as mu, b/h and the angle say") {
  struct incline {
    real angle, mu;
    vec3 size;
    bool slides, tips;
  };
  for (const int ranks : {1, 4})
    for (const incline& c :
         {incline{30, 0.4, {1, 1, 1}, true, false}, incline{30, 0.6, {1, 1, 1}, false, false},
          incline{25, 0.4, {0.5, 1, 1}, true, false}, incline{25, 0.5, {0.5, 1, 1}, false, false},
          incline{28, 0.6, {0.5, 1, 1}, false, true}}) {
      const real angle = c.angle * degree;
      const vec3 up{std::sin(angle), 0, std::cos(angle)},
          along{std::cos(angle), 0, -std::sin(angle)};
      const auto all = watch(ranks, 2, [&](auto& w) {
        const auto m = w.material({.friction = c.mu});
        w.gravity({0, 0, -g});
        w.global([&](auto& s) { s.add(plane{.normal = up}, m); });
        w.add_if_local(body{
            .shape = box{c.size}, .position = 0.5 * c.size[2] * up, .orientation = about_y(angle)});
      });
      const std::string test = "box on an incline" + on(ranks),
                        what = fmt::format("{} degrees, mu {}, b/h {}", c.angle, c.mu,
                                           c.size[0] / c.size[2]);
      const moment& end = all[0].back();
      check_holds(test, what + ": tips", c.tips, (end.orientation * vec3::UnitZ()).dot(up) < 0.9);
      if (!c.tips)
        check_absolute(test, what + ": speed after 2 s",
                       c.slides ? 2 * g * (std::sin(angle) - c.mu * std::cos(angle)) : 0,
                       along.dot(end.velocity), 2e-8);  // a settled step may leave 1e-4 of g dt
    }
}

TEST_CASE(
    "the wave through a row of dominoes has a steady speed, which grows with the root of its "
    "size") {
  const auto speeds = speeds_of_wave(1, 1, dt);
  check_steady("dominoes, 1 rank", speeds);
  check_relative("dominoes", "speed at four times the size to twice that at one", 1,
                 mean_of(speeds_of_wave(1, 4, 2 * dt)) / (2 * mean_of(speeds)), 0.01);
}
