// Walls held at forces and pressures that change in time, against closed forms.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/features/driven/plane_area.hpp>
#include <talus/observe/critical_dt.hpp>
#include <talus/observe/force.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

template <class Law, class Decomposition = decomposition<grid<dynamic>>>
using scene =
    scenario<bodies<sphere, plane>, Law, transport<threads>, Decomposition, features<driven>>;
using hard = hard_contact<coulomb_friction>;
using soft = soft_contact<linear_spring_dashpot, coulomb_friction>;

constexpr real k = 2e4, r = 0.5;
constexpr int spheres = 6;

/// A row of spheres between a floor and a lid that presses with 20 + 10 t from 2 to 4, and is asked
/// again for the same now and then. Returns the final position of the lid.
template <class Law>
real press_row(int ranks, real dt) {
  real end = 0;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scene<Law>> w(link, {.lower = {0}, .upper = {2 * r * spheres}});
    const auto m = w.material({.density = 2, .restitution = 0.1, .stiffness = k});
    handle<plane> lid, floor;
    w.global([&](auto& s) {
      floor = s.add(plane{.normal = {1, 0, 0}}, m);
      lid = s.add(plane{.normal = {-1, 0, 0}, .offset = -(2 * r * spheres + 0.05)}, m);
    });
    for (int i = 0; i < spheres; ++i)
      w.add_if_local(body{.shape = sphere{r}, .position = {r + 2 * r * i, 0, 0}, .material = m});
    const auto force = [](real t) { return 20 + 10 * std::clamp(t - 2, real(0), real(2)); };
    const servo how{.force = force, .max_speed = 0.2};
    w.hold_force(lid, how);
    real before = 0, worst = 0;
    const auto steps = static_cast<int>(std::lround(6 / dt));
    for (int n = 1; n <= steps; ++n) {
      w.step(dt);
      if (n % (steps / 40) == 0) w.hold_force(lid, how);
      if (n == steps / 3) before = w[lid].position()[0];
      if (n < steps / 3 || n % (steps / 60) != 0) continue;
      worst = std::max(worst, std::abs(contact_force(w, lid)[0] - force(w.time())));
      worst = std::max(worst, std::abs(contact_force(w, floor)[0] + force(w.time())));
    }
    CHECK(worst < 0.2);  // half a percent of the force
    if (w.rank() == 0) end = w[lid].position()[0];
    if constexpr (Law::soft)  // two contacts in a row are as soft as half of one
      CHECK(before - w[lid].position()[0] == doctest::Approx((spheres + 1) * 20 / k).epsilon(1e-3));
  });
  return end;
}

/// A sphere in a cell of six planes of which three press, each on its present area.
void press_in_cell(real dt, real tolerance) {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<scene<soft>> w(link, {.lower = {-5}, .upper = {5}});
    const auto m = w.material({.density = 2, .restitution = 0.3, .stiffness = 500});
    std::array<handle<plane>, 3> fixed, walls;
    w.global([&](auto& s) {
      for (int axis = 0; axis < 3; ++axis) {
        vec3 n(0, 0, 0);
        n[axis] = 1;
        fixed[std::size_t(axis)] = s.add(plane{.normal = n, .offset = -r}, m);
        walls[std::size_t(axis)] = s.add(plane{.normal = -n, .offset = -r - 0.02 * axis}, m);
      }
    });
    w.add_if_local(body{.shape = sphere{r}, .material = m});
    const std::array<real, 3> p{20, 40, 60};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto pressure = [most = p[axis]](real t) { return most * std::min(t, 1.); };
      w.hold_force(walls[axis], {.pressure = pressure, .max_speed = 0.1});
    }
    for (int n = 0; n * dt < 4; ++n) w.step(dt);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      real area = 1;
      for (std::size_t other = 0; other < 3; ++other)
        if (other != axis) area *= r - w[walls[other]].shape().offset;
      CHECK(contact_force(w, walls[axis])[int(axis)] ==
            doctest::Approx(p[axis] * area).epsilon(tolerance));
      CHECK(area < 1);
    }
  });
}

}  // namespace

TEST_CASE("a row bears the force that a lid has at each time") {
  CHECK(press_row<soft>(1, 2e-4) == press_row<soft>(3, 2e-4));
  CHECK(press_row<hard>(1, 2e-3) == doctest::Approx(press_row<hard>(3, 2e-3)));
}

TEST_CASE("walls press on areas that follow the other walls") { press_in_cell(1e-3, 1e-3); }

TEST_CASE("critical_dt counts the largest speed of a servo") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scene<soft_contact<hertz_mindlin, coulomb_friction>>> w(link,
                                                                  {.lower = {-5}, .upper = {5}});
    const auto m = w.material({.density = 2, .youngs_modulus = 1e5});
    handle<plane> lid;
    w.global([&](auto& s) { lid = s.add(plane{.normal = {0, 0, -1}, .offset = -2}, m); });
    w.add(sphere{r}, m, {0, 0, 0});
    const real at_rest = critical_dt(w);
    w.hold_force(lid, {.force = 1, .max_speed = 30});
    CHECK(critical_dt(w) == critical_dt(w, 30));
    CHECK(critical_dt(w) < at_rest);
  });
}

TEST_CASE("the area of a plane is that of the face that other planes leave of it") {
  using detail::area_within;
  const real h = std::sqrt(real(0.5));
  CHECK(area_within({{1, 0, 0}, {0, 1, 0}, {-h, -h, -h}}) == doctest::Approx(0.5));
  CHECK(area_within({{1, 0, 3}, {-1, 0, -5}, {0, 1, -7}, {0, -1, 4}}) == doctest::Approx(6));
  CHECK(area_within({{1, 0, 3}, {1, 0, 3}, {1, 0, 1}, {-1, 0, -5}, {0, 1, -7}, {0, -1, 4}}) ==
        doctest::Approx(6));
  CHECK(area_within({{1, 0, 5}, {-1, 0, -3}, {0, 1, -7}, {0, -1, 4}}) == 0);
  CHECK(std::isinf(area_within({})));
  CHECK(std::isinf(area_within({{1, 0, 0}})));
  CHECK(std::isinf(area_within({{1, 0, 0}, {-1, 0, -1}})));
  CHECK(std::isinf(area_within({{1, 0, 0}, {0, 1, 0}, {-1, 0, -5}})));
}

TEST_CASE("a periodic box bounds a plane, and a plane without bounds has no area") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    using layer = scene<hard, decomposition<periodic<grid<dynamic, dynamic>, along::x, along::y>>>;
    world<layer> w(link, {{.lower = {0, 0}, .upper = {4, 3}}});
    const auto m = w.material({.density = 2});
    handle<plane> lid;
    w.global([&](auto& s) {
      s.add(plane{}, m);
      lid = s.add(plane{.normal = {0, 0, -1}, .offset = -1}, m);
    });
    w.add(sphere{r}, m, {2, 1, r});
    w.hold_force(lid, {.pressure = 2, .max_speed = 0.1});
    for (int n = 0; n < 400; ++n) w.step(0.01);
    CHECK(contact_force(w, lid)[2] == doctest::Approx(24).epsilon(1e-3));
  });
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scene<hard>> w(link);
    const auto m = w.material({.density = 2});
    handle<plane> lid;
    w.global([&](auto& s) { lid = s.add(plane{.normal = {0, 0, -1}, .offset = -1}, m); });
    CHECK_THROWS_WITH_AS(w.hold_force(lid, {.force = 1, .pressure = 1, .max_speed = 1}),
                         doctest::Contains("given both"), std::invalid_argument);
    CHECK_THROWS_WITH_AS(w.hold_force(lid, {.max_speed = 1}), doctest::Contains("given neither"),
                         std::invalid_argument);
    CHECK_THROWS_AS(w.hold_force(lid, {.pressure = -1, .max_speed = 1}), std::invalid_argument);
    w.hold_force(lid, {.pressure = 2, .max_speed = 0.1});
    CHECK_THROWS_WITH_AS(w.step(0.01), doctest::Contains("do not bound"), std::runtime_error);
    w.hold_force(lid, {.force = [](real t) { return 1 - 1000 * t; }, .max_speed = 0.1});
    CHECK_THROWS_WITH_AS(w.step(0.01), doctest::Contains("the force of servo"), std::runtime_error);
  });
}
