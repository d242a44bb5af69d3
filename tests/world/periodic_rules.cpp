// Rules of a periodic box besides the motion: reports, counts and refusals.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <set>
#include <string>
#include <talus/observe/flow.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/reach.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/world/each_contact.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;
using doctest::Contains;

namespace {

template <class... More>
using sideways = scenario<bodies<sphere, plane>, transport<threads>,
                          decomposition<periodic<grid<dynamic>, along::x, along::y>>, More...>;
using soft = sideways<soft_contact<linear_spring_dashpot, coulomb_friction>>;

/// Runs `main(world)` on x by y ranks, in a box of 8 x 6 around the origin.
template <class Scenario, class Main>
void on(int x, int y, Main&& main) {
  CAPTURE(x);
  CAPTURE(y);
  threads::launch({.ranks = x * y}, [&](threads::link& link) {
    world<Scenario> w(link, {{.cells = {x, y, 1}, .lower = {-4, -3}, .upper = {4, 3}}}, reach{1});
    main(w);
  });
}
const std::vector<std::pair<int, int>> shares{{1, 1}, {2, 1}, {3, 2}, {4, 3}};

}  // namespace

TEST_CASE("a ring of soft spheres around the box has each contact once, between neighbours") {
  for (const auto& [x, y] : shares) {
    std::multiset<std::pair<system_id, system_id>> pairs;
    std::mutex mutex;
    on<soft>(x, y, [&](auto& w) {
      w.material({.stiffness = 1e4});
      w.fill(simple_cubic{.spacing = 1, .origin = {-3.9, 2.95, 0}} &
                 box_region{.lower = {-4, 2.9, -0.1}, .upper = {4, 3, 0.1}},
             [](const site& place) {
               return body{.shape = sphere{0.51}, .position = place.position};
             });
      for (int k = 0; k < 10; ++k) w.step(1e-4);
      for_each_contact(w, [&](const loaded_contact& c) {
        CHECK(c.normal_force() == doctest::Approx(200));
        CHECK((c.centre_a - c.centre_b).norm() == doctest::Approx(1));
        CHECK((c.point - 0.5 * (c.centre_a + c.centre_b)).norm() < 1e-9);
        const std::lock_guard lock(mutex);
        pairs.insert({std::min(c.a, c.b), std::max(c.a, c.b)});
      });
    });
    CHECK(pairs.size() == 8);
    CHECK(std::set(pairs.begin(), pairs.end()).size() == 8);
  }
}

TEST_CASE("soft spheres that meet across a side part with the momentum of those that meet inside") {
  const auto meet = [](double place, int x, int y) {
    vec3 seen{0, 0, 0};
    std::mutex mutex;
    on<soft>(x, y, [&](auto& w) {
      w.material({.restitution = 0.7, .friction = 0.4, .stiffness = 1e4});
      for (const double side : {-1.0, 1.0})
        w.add_if_local(body{.shape = sphere{0.5},
                            .position = talus::detail::state_of(w).own.box().wrapped(
                                vec3(place + 0.6 * side, 0.1 * side, 0)),
                            .velocity = {-side, 0, 0},
                            .angular_velocity = {0, 0, side}});
      for (int k = 0; k < 4000; ++k) w.step(1e-4);
      const motion all = measure_motion(w);
      CHECK(all.momentum.norm() < 1e-12);
      w.for_each_local([&](const auto& b) {
        const std::lock_guard lock(mutex);
        if (value_of(b.id()) & 1) seen = b.velocity();
      });
    });
    return seen;
  };
  const vec3 inside = meet(0, 1, 1);
  CHECK(inside[0] == doctest::Approx(0.7).epsilon(0.03));
  for (const auto& [x, y] : shares) CHECK((meet(4, x, y) - inside).norm() < 1e-9);
}

TEST_CASE("hard spheres that press on each other across a side have one contact, beside them") {
  for (const auto& [x, y] : shares) {
    std::array<int, 5> contacts{};  // after each step
    std::mutex mutex;
    on<sideways<>>(x, y, [&](auto& w) {
      w.material({.restitution = 0});
      for (const double side : {-1.0, 1.0})
        w.add_if_local(
            body{.shape = sphere{0.5}, .position = {side * 3.49, 0, 0}, .velocity = {side, 0, 0}});
      for (int& count : contacts) {
        w.step(0.01);
        for_each_contact(w, [&](const loaded_contact& c) {
          CHECK((c.point - 0.5 * (c.centre_a + c.centre_b)).norm() < 1e-3);
          CHECK((c.centre_a - c.centre_b).norm() == doctest::Approx(1).epsilon(0.03));
          const std::lock_guard lock(mutex);
          ++count;
        });
        w.link().barrier();
      }
    });
    CHECK(*std::max_element(contacts.begin(), contacts.end()) == 1);
  }
}

TEST_CASE("a flow is counted where bodies cross the plane, not where they come in again") {
  for (const auto& [x, y] : shares)
    on<sideways<>>(x, y, [&](auto& w) {
      w.material({});
      w.add_if_local(body{.shape = sphere{0.3}, .position = {0, 2, 0}, .velocity = {3, -2, 0}});
      flow_meter inside(w, plane{.normal = {1, 0, 0}, .offset = 1});
      flow_meter at_side(w, plane{.normal = {0, -1, 0}, .offset = 2.9999});
      w.simulate({.steps = 2000, .dt = 0.01});  // 60 along x, -40 along y
      const flow a = inside.total(), b = at_side.total();
      CHECK(a.forward == 8);
      CHECK(a.backward == 0);
      CHECK(b.forward == 6);
      CHECK(b.backward == 0);
      w.for_each_local([&](const auto& body) {
        CHECK(body.velocity() == vec3(3, -2, 0));
        CHECK((talus::detail::state_of(w).own.box().nearest(body.position(), {4, -2, 0}) -
               vec3(4, -2, 0))
                  .norm() < 1e-9);
      });
    });
}

TEST_CASE("what is wrong in a periodic box is refused with its numbers") {
  using scene = sideways<>;
  const auto refuses = [](auto main, const char* text) {
    CHECK_THROWS_WITH_AS(on<scene>(2, 1,
                                   [&](auto& w) {
                                     w.material({});
                                     main(w);
                                     w.step(0.01);
                                   }),
                         Contains(text), std::exception);
  };
  const auto add = [](auto& w, double radius, const vec3& place, double speed = 0) {
    w.add_if_local(body{.shape = sphere{radius}, .position = place, .velocity = {speed, 0, 0}});
  };
  refuses([&](auto& w) { add(w, 0.5, {4, 0, 0}); }, "outside of the periodic box");
  refuses([&](auto& w) { add(w, 0.5, {0, -7, 0}); }, "add its image in there, at (0, -1, 0)");
  refuses([&](auto& w) { add(w, 1.6, {0, 0, 0}); }, "at most a quarter of it");
  refuses([&](auto& w) { add(w, 0.5, {0, 0, 0}, 120); }, "at most a quarter of it");
  refuses([&](auto& w) { w.connect(1 - w.rank(), vec3(1, 0, 0), 0.0); }, "makes all connections");
  refuses([&](auto& w) { w.disconnect(1 - w.rank()); }, "makes all connections");
  CHECK_THROWS_WITH_AS((periodic<grid<2>, along::x>{{.upper = {1}}}.resolve(2)),
                       Contains("the sides of the box there are nan and 1"), std::invalid_argument);
  CHECK_THROWS_WITH_AS(
      (periodic<grid<dynamic>, along::z>{{.lower = {0, 0, 2}, .upper = {1, 1, 1}}}.resolve(1)),
      Contains("space is periodic along z"), std::invalid_argument);
}

TEST_CASE("a body that the user puts outside of the box comes in on the other side") {
  for (const auto& [x, y] : shares)
    on<sideways<>>(x, y, [&](auto& w) {
      w.material({});
      w.add_if_local(body{.shape = sphere{0.3}, .position = {1, 1, 1}});
      w.step(0.01);
      w.for_each_local([](auto& b) { b.translate({20, -15.5, 0}); });
      w.synchronize();
      CHECK(w.audit().bodies == 1);
      w.for_each_local(
          [&](const auto& b) { CHECK((b.position() - vec3(-3, -2.5, 1)).norm() < 1e-12); });
    });
}

TEST_CASE("what is in the way is seen across the sides, of the box and of the ranks") {
  for (const auto& [x, y] : shares)
    on<sideways<>>(x, y, [&](auto& w) {
      w.material({});
      w.add_if_local(body{.shape = sphere{0.3}, .position = {-3.6, -2.6, 0}});
      w.synchronize();
      std::array<double, 3> found{
          double(w.overlaps(sphere{0.5}, {3.9, 2.9, 0})),  // 0.71 away from there
          double(w.overlaps(sphere{0.4}, {3.9, 2.9, 0})),
          double(w.overlaps(sphere{0.5}, {0, 0, 0}))};
      w.link().reduce(reduction::max, std::span<double>(found));
      CHECK(found[0] == 1);
      CHECK(found[1] == 0);
      CHECK(found[2] == 0);
    });
}
