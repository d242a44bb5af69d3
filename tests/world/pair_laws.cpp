// The laws of contacts of a pair, for any shapes and on any number of ranks: act on both bodies,
// and be found.
#include <doctest/doctest.h>

#include <cmath>
#include <mutex>
#include <talus/observe/coordination.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "../scenes/solids.hpp"

using namespace talus;

namespace {

using cells = grid<dynamic>;
using scene = scenes::solids;
using world_type = world<scene>;

/// Calls f(world) on each of so many ranks, that of a negative x being the first of two.
template <class F>
void on_ranks(int ranks, F&& f) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world_type w(link, cells{.lower = {-100}, .upper = {100}});
    f(w);
  });
}

struct pair_of_bodies {
  vec3 a, b;  ///< displacements
};

/// Pairs of bodies that overlap along x, side by side, after a step in which only the correction
/// moves them. The heavier one has twice the density.
template <class A, class B>
std::vector<pair_of_bodies> correct(const A& a, const B& b, real apart, int pairs, int ranks) {
  std::vector<pair_of_bodies> moved(static_cast<std::size_t>(pairs));
  std::mutex one_by_one;
  on_ranks(ranks, [&](world_type& w) {
    const auto light = w.material({.density = 1}), heavy = w.material({.density = 2});
    std::vector<handle<A>> all_a;
    std::vector<handle<B>> all_b;
    for (int k = 0; k < pairs; ++k) {
      const vec3 at_a{-apart / 2, 5.0 * k, 0}, at_b{apart / 2, 5.0 * k, 0};
      if (const auto h = w.add_if_local(body{.shape = a, .position = at_a, .material = light}))
        all_a.push_back(*h);
      else
        all_a.push_back({});
      if (const auto h = w.add_if_local(body{.shape = b, .position = at_b, .material = heavy}))
        all_b.push_back(*h);
      else
        all_b.push_back({});
    }
    w.step(0.01);
    const std::lock_guard lock(one_by_one);
    for (std::size_t k = 0; k < moved.size(); ++k) {
      const real y = 5 * static_cast<real>(k);
      const auto note = [&](auto handle, vec3& to, real x) {
        if (const auto found = w.find(handle); found && !found->is_remote()) {
          to = found->position() - vec3(x, y, 0);
          CHECK(found->velocity().norm() < 1e-14);
        }
      };
      note(all_a[k], moved[k].a, -apart / 2);
      note(all_b[k], moved[k].b, apart / 2);
    }
  });
  return moved;
}

}  // namespace

TEST_CASE("the correction of an overlap moves both bodies, each by what its mass is to the other") {
  const auto check = [](const auto& a, const auto& b, real apart, const char* name) {
    const real ratio = 2 * b.volume() / a.volume();  // of the masses
    for (const int ranks : {1, 2})
      for (const int pairs : {1, 40}) {
        CAPTURE(name);
        CAPTURE(ranks);
        CAPTURE(pairs);
        for (const auto& [of_a, of_b] : correct(a, b, apart, pairs, ranks)) {
          CHECK(of_a[0] < -1e-4);
          CHECK(of_b[0] > 1e-5);
          CHECK(-of_a[0] == doctest::Approx(ratio * of_b[0]).epsilon(1e-9));
        }
      }
  };
  check(sphere{0.5}, sphere{0.5}, 0.99, "spheres");
  check(sphere{0.5}, box{{1, 1, 1}}, 0.99, "sphere and box");
  check(box{{1, 1, 1}}, box{{1, 1, 1}}, 0.99, "boxes");
}

TEST_CASE("bodies of two materials rebound with the mean of their restitutions") {
  for (const bool swapped : {false, true})
    on_ranks(1, [&](world_type& w) {
      const auto a = w.material({.restitution = swapped ? 0.2 : 0.8}),
                 b = w.material({.restitution = swapped ? 0.8 : 0.2});
      const auto left = w.add(
          body{.shape = sphere{0.5}, .position = {0, 0, 0}, .material = a, .velocity = {1, 0, 0}});
      const auto right = w.add(body{.shape = sphere{0.5}, .position = {1, 0, 0}, .material = b});
      w.step(0.01);
      CHECK((w[right].velocity() - w[left].velocity())[0] == doctest::Approx(0.5));
    });
}

TEST_CASE("a body that several bodies of another rank strike at once gains no energy") {
  // Boundary contacts are solved simultaneously: with undivided masses each would give the full
  // impulse.
  for (const int spheres : {2, 4, 6})
    for (const int iterations : {1, 2, 3, 10}) {
      CAPTURE(spheres);
      CAPTURE(iterations);
      on_ranks(2, [&](world_type& w) {
        const auto light = w.material({.density = 1e-3}), heavy = w.material({.density = 1});
        w.solver().iterations = iterations;
        (void)w.add_if_local(
            body{.shape = sphere{1}, .position = {-1e-3, 0, 0}, .material = light});
        for (int k = 0; k < spheres; ++k) {
          const real turn = 2 * pi * k / spheres, tilt = 0.7;
          const vec3 to{std::cos(tilt), std::sin(tilt) * std::cos(turn),
                        std::sin(tilt) * std::sin(turn)};
          (void)w.add_if_local(body{.shape = sphere{0.3},
                                    .position = vec3(-1e-3, 0, 0) + 1.3 * to,
                                    .material = heavy,
                                    .velocity = {-1, 0, 0}});
        }
        w.synchronize();
        const auto before = measure_motion(w);
        w.step(1e-3);
        const auto after = measure_motion(w);
        CHECK(after.kinetic_energy <= before.kinetic_energy * (1 + 1e-12));
        CHECK((after.momentum - before.momentum).norm() < 1e-14);
        CHECK(after.max_speed <= 1 + 1e-9);
      });
    }
}

TEST_CASE("what touches from as far as bodies reach is found on both of two ranks") {
  // One sphere has its centre at the boundary, the other touches it from the other side: at the
  // largest distance from the boundary at which a body can touch something there. In every
  // direction, of every ratio of sizes, at speeds that add next to nothing to the reach of bodies.
  for (const real ratio : {1.0, 0.5, 0.1})
    for (const bool left : {false, true})
      for (const real speed : {1e-3, 1.0}) {
        CAPTURE(ratio);
        CAPTURE(left);
        CAPTURE(speed);
        on_ranks(2, [&](world_type& w) {
          w.material({.density = 1, .restitution = 1});
          const real side = left ? -1 : 1, dt = 1e-4;
          const auto at = [&](real x) { return vec3{side * x, 0, 0}; };
          (void)w.add_if_local(body{.shape = sphere{1}, .position = at(1e-6)});
          (void)w.add_if_local(body{.shape = sphere{ratio},
                                    .position = at(1e-6 - 1 - ratio - 0.4 * speed * dt),
                                    .velocity = at(speed)});
          w.step(dt);
          w.for_each_local([&](const auto& b) {
            const bool struck = b.shape().bounding_radius() == 1 && b.position()[0] * side > 0;
            const real m = ratio * ratio * ratio;
            if (struck) CHECK(side * b.velocity()[0] == doctest::Approx(2 * m / (1 + m) * speed));
          });
          const auto motion = measure_motion(w);
          CHECK(motion.kinetic_energy ==
                doctest::Approx(0.5 * 4 / 3 * pi * ratio * ratio * ratio * speed * speed));
        });
      }
}

TEST_CASE("a gap that gravity closes within the step is closed, not passed") {
  for (const real g : {1.0, 10.0})
    for (const real part : {0.0, 0.2, 0.5, 0.9, 0.99, 1.01, 1.5})
      on_ranks(1, [&](world_type& w) {
        const real dt = 1.0 / 60, gap = part * g * dt * dt;
        CAPTURE(g);
        CAPTURE(gap);
        w.material({});
        w.gravity({0, 0, -g});
        w.global([](auto& s) { s.add(plane{}, {}); });
        const auto h = w.add(body{.shape = sphere{1}, .position = {0, 0, 1 + gap}});
        w.step(dt);
        CHECK(w[h].position()[2] > 1 - 1e-9);
      });
}

TEST_CASE("points touch up to a gap of a thousandth of the mean radius") {
  on_ranks(1, [](world_type& w) {
    w.material({});
    real y = 0;
    for (const real gap : {-0.01, 0.0005, 0.002, 0.05}) {  // over the radius
      w.add(body{.shape = sphere{0.5}, .position = {0, y, 0}});
      w.add(body{.shape = sphere{0.5}, .position = {1 + gap / 2, y, 0}});
      y += 5;
    }
    w.synchronize();
    const auto p = measure_penetration(w);
    CHECK(p.touching == 2);
    CHECK(p.max == doctest::Approx(0.01));
  });
}

TEST_CASE("the coefficients of a pair are the means of those of its materials") {
  material_table all;
  const auto a = all.add({.restitution = 0.2, .friction = 0.5, .dynamic_friction = 0.3});
  const auto b = all.add({.restitution = 0.6, .friction = 0.1, .dynamic_friction = 0.05});
  for (const pair_material& p : {all.pair(a, b), all.pair(b, a)}) {
    CHECK(p.restitution == doctest::Approx(0.4));
    CHECK(p.friction == doctest::Approx(0.3));
    CHECK(p.dynamic_friction == doctest::Approx(0.175));
  }
}

TEST_CASE("a body is one neighbour of another, however many points of contact they have") {
  on_ranks(1, [](world_type& w) {
    const auto stone = w.material({.density = 1, .friction = 0.5});
    w.gravity({0, 0, -10});
    w.global([&](auto& scope) { scope.add(plane{}, stone); });
    w.add(body{.shape = box{{1, 1, 1}}, .position = {1, 0, 0.5}, .material = stone});
    w.add(body{.shape = box{{1, 1, 1}}, .position = {1, 0, 1.5}, .material = stone});
    for (int k = 0; k < 20; ++k) w.step(0.005);
    const coordination found = measure_coordination(w);
    CHECK(found.bodies == 2);
    CHECK(found.mean == doctest::Approx(1.5));  // the lower one has the plane and the upper one
  });
}
