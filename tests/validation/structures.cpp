// timeout: 300
// Structures that stand or fall by a closed form, at the default settings: overhanging blocks,
// leaning cards, the semicircular arch of wedges, tall boxes, and the wave that runs through
// dominoes. (Blocks and arch on four ranks, and arches of
// little friction: structures_long.cpp.)
#include <doctest/doctest.h>

#include "structures.hpp"

using namespace talus;
using namespace talus::validation;

TEST_CASE(
    "blocks overhang by L/2 (1 + 1/2 + ... + 1/n): they stand at 0.99 and fall at 1.01 of it") {
  const int ranks = 1;
  for (int n = 1; n <= 5; ++n)
    for (const real part : {0.99, 1.01})
      check_stands("overhang" + on(ranks),
                   std::to_string(n) + " blocks at " + fmt::format("{:.2f}", part), part < 1,
                   watch(
                       ranks, part < 1 ? 3 : 5, [&](auto& w) { overhang(w, n, part); }),
                   1);
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

TEST_CASE("a semicircular arch of wedges stands at 1.02 and falls at 0.98 of the least thickness") {
  const int ranks = 1;
  for (const auto& [n, least] : {std::pair{18, 0.105964}, std::pair{20, 0.10746}})
    for (const real part : {0.98, 1.02})
      check_stands("arch" + on(ranks), fmt::format("{} wedges at {:.2f}", n, part), part > 1,
                   watch(ranks, part > 1 ? 3 : 6, [&](auto& w) { arch(w, n, part * least, 0.7); }),
                   1);
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
                       along.dot(end.velocity), 1e-9);
    }
}

TEST_CASE(
    "the wave through a row of dominoes has a steady speed, which grows with the root of its "
    "size") {
  // Height 1, thickness 0.1, width 0.5, distance of the centres 0.4, mu 0.2; the first is pushed.
  constexpr int count = 30;
  const auto speed_of_wave = [&](int ranks, real unit, real step) {
    const auto all = watch(
        ranks, 4.2 * std::sqrt(unit),
        [&](auto& w) {
          const auto m = w.material({.friction = 0.2});
          w.gravity({0, 0, -g});
          w.global([&](auto& s) { s.add(plane{}, m); });
          for (int k = 0; k < count; ++k)
            w.add_if_local(
                body{.shape = box{unit * vec3(0.1, 0.5, 1)},
                     .position = unit * vec3(0.4 * (k - count / 2), 0, 0.5),
                     .angular_velocity = k == 0 ? vec3(0, 3 / std::sqrt(unit), 0) : vec3(0, 0, 0)});
        },
        step);
    // When each has turned by a tenth of a radian.
    std::vector<real> when;
    for (const auto& way : all)
      for (std::size_t k = 1; k < way.size(); ++k) {
        const auto tilt = [&](std::size_t i) {
          return std::asin((way[i].orientation * vec3::UnitZ())[0]);
        };
        if (tilt(k) < 0.1) continue;
        when.push_back(step * (real(k) - (tilt(k) - 0.1) / (tilt(k) - tilt(k - 1))));
        break;
      }
    REQUIRE(when.size() == count);
    std::vector<real> speeds;  // over five dominoes each, after the first ten
    for (int k = 10; k + 5 < count; k += 5)
      speeds.push_back(unit * 0.4 * 5 / (when[std::size_t(k + 5)] - when[std::size_t(k)]));
    return speeds;
  };
  real alone = 0;
  for (const int ranks : {1, 4}) {
    const auto speeds = speed_of_wave(ranks, 1, dt);
    const auto [slow, fast] = std::minmax_element(speeds.begin(), speeds.end());
    const real mean = std::accumulate(speeds.begin(), speeds.end(), 0.0) / real(speeds.size());
    MESSAGE("speed of the wave over sqrt(g h): ", mean / std::sqrt(g), " from ",
            *slow / std::sqrt(g), " to ", *fast / std::sqrt(g));
    check_error("dominoes" + on(ranks), "spread of the speed after the first ten",
                (*fast - *slow) / mean, 0.05);
    if (ranks == 1)
      alone = mean;
    else
      check_relative("dominoes", "speed on 4 ranks to that on 1", 1, mean / alone, 0.02);
  }
  const auto large = speed_of_wave(1, 4, 2 * dt);
  const real mean = std::accumulate(large.begin(), large.end(), 0.0) / real(large.size());
  check_relative("dominoes", "speed at four times the size to twice that at one", 1,
                 mean / (2 * alone), 0.01);
}
