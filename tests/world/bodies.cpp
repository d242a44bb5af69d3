// Adding, changing, finding and destroying bodies, and the messages for wrong input.
#include <doctest/doctest.h>

#include <limits>
#include <stdexcept>
#include <talus/parallel/serial.hpp>
#include <talus/scene/site.hpp>
#include <talus/world/world.hpp>

using namespace talus;
using alone = scenario<bodies<sphere, box, plane>, transport<serial>,
                       features<forces, user_ids, visibility, damping>>;

namespace {

constexpr double bad = std::numeric_limits<double>::quiet_NaN();

template <class Error = std::invalid_argument, class F>
void refused(F&& f, const char* because) {
  CHECK_THROWS_WITH_AS(f(), doctest::Contains(because), Error);
}

}  // namespace

TEST_CASE("a world has room for 65,535 materials, each pair with properties of its own if set") {
  serial::link link;
  world<alone> w(link);
  constexpr std::size_t n = 65535;
  for (std::size_t k = 0; k < n; ++k)
    (void)w.material({.restitution = real(k % 10) / 10, .friction = real(k % 100) / 100});
  refused([&] { (void)w.material({}); }, "at most 65535 materials");
  const auto id = [](std::size_t k) { return static_cast<material_id>(k); };
  const material_table& all = w.materials();
  for (std::size_t k = 0; k + 1 < n; k += 2)
    w.material_pair(id(k + 1), id(k), {.restitution = 0.05, .friction = real(k)});
  for (std::size_t k = 0; k + 2 < n; ++k) {
    const pair_material own = all.pair(id(k), id(k + 1)), mean = all.pair(id(k), id(k + 2));
    REQUIRE(all.pair(id(k + 1), id(k)).friction == own.friction);
    REQUIRE(mean.friction == 0.5 * (all[id(k)].friction + all[id(k + 2)].friction));
    if (k % 2 == 0) REQUIRE((own.friction == real(k) && own.sliding_friction() == real(k)));
    if (k % 2 == 1)
      REQUIRE(own.restitution == 0.5 * (all[id(k)].restitution + all[id(k + 1)].restitution));
  }
  w.material_pair(id(4), id(5), {.friction = 7});  // once more
  CHECK(all.pair(id(5), id(4)).friction == 7);
  CHECK(all.pair(id(5), id(4)).restitution == 0);
  CHECK(all.own_pairs().entries().size() == n / 2);
}

TEST_CASE("bad bodies are refused with the value that is wrong") {
  serial::link link;
  world<alone> w(link);
  refused([&] { w.add(body{.shape = sphere{1}}); }, "no material yet");
  const auto stuff = w.material({});
  refused([&] { w.add(body{.shape = sphere{0}, .material = stuff}); },
          "radius of a sphere must be positive");
  refused([&] { w.add(body{.shape = sphere{bad}, .material = stuff}); }, "nan");
  refused([&] { w.add(body{.shape = box{{1, -2, 1}}, .material = stuff}); }, "-2");
  refused(
      [&] {
        w.add(body{.shape = sphere{1}, .position = {0, bad, 0}, .material = stuff});
      },
      "the position of a body must be finite");
  refused(
      [&] {
        w.add(body{.shape = sphere{1}, .material = stuff, .velocity = {bad, 0, 0}});
      },
      "the velocity of a body must be finite");
  refused(
      [&] {
        w.add(body{.shape = sphere{1}, .material = stuff, .orientation = {2, 0, 0, 0}});
      },
      "unit quaternion");
  refused([&] { w.add(body{.shape = sphere{1}, .material = material_id{9}}); },
          "material 9 is unknown");
  refused([&] { w.material({.density = -1}); }, "density");
  refused([&] { w.material({.restitution = 1.5}); }, "restitution");
  refused([&] { w.material({.friction = 0.2, .dynamic_friction = 0.3}); }, "dynamic friction");
  refused([&] { w.gravity({0, 0, bad}); }, "gravity");
  refused([&] { w.damping(1.2); }, "damping");
  refused([&] { w.step(0); }, "time step");
  refused([&] { w.step(bad); }, "time step");
  refused([&] { w.add(body{.shape = sphere{1e-110}, .material = stuff}); }, "the mass of a sphere");
  refused([&] { w.add(body{.shape = sphere{1e110}, .material = stuff}); }, "the mass of a sphere");
  refused([&] { (void)w.overlaps(sphere{-1}, {0, 0, 0}); }, "radius of a sphere");
  refused([&] { (void)w.overlaps(sphere{1}, {0, bad, 0}); }, "the position of an overlap query");
  w.solver().iterations = 0;
  refused([&] { w.step(0.1); }, "at least 1 iteration, 0 of the correction");
  w.solver() = {.correction = 2};
  refused([&] { w.step(0.1); }, "to correct, but has 10, 3 and 2");
  w.solver() = {};
  CHECK(w.local_bodies() == 0);
}

TEST_CASE("bodies carry what the user gave them and do what they are told") {
  serial::link link;
  world<alone> w(link);
  const auto stuff = w.material({.density = 2});
  const auto h =
      w.add(body{.shape = sphere{0.5}, .position = {1, 2, 3}, .material = stuff, .user_id = 42});
  auto b = w[h];
  CHECK(b.user_id() == 42);
  CHECK(b.mass() == doctest::Approx(2 * 4 * pi / 3 * 0.125));
  CHECK_FALSE(b.is_remote());
  CHECK_FALSE(b.is_global());
  CHECK(b.is_visible());
  b.set_visible(false);
  CHECK_FALSE(b.is_visible());
  b.translate({1, 0, 0});
  CHECK(b.position() == vec3(2, 2, 3));
  b.add_force({b.mass() * 8, 0, 0});
  w.step(0.5);
  CHECK(w[h].velocity()[0] == doctest::Approx(4));
  CHECK(w[h].position()[0] == doctest::Approx(4));
  w.step(0.5);
  CHECK(w[h].velocity()[0] == doctest::Approx(4));  // a force lasts one step
  w[h].fix();
  w.step(0.5);
  CHECK(w[h].position()[0] == doctest::Approx(6));
  w[h].release();
  w[h].add_torque({0, 0, 1});
  w.step(0.5);
  CHECK(w[h].angular_velocity()[2] == doctest::Approx(0.5 / w[h].inertia()[2]));
  refused([&] { w[h].add_force({bad, 0, 0}); }, "force of body");
  w.destroy(h);
  CHECK_FALSE(w.find(h).has_value());
  refused([&] { w.destroy(h); }, "does not know the sphere");
}

TEST_CASE("damping keeps its fraction of the velocity per unit of time, whatever the step") {
  for (const int n : {1, 10, 100}) {
    serial::link link;
    world<alone> w(link);
    const auto stuff = w.material({});
    w.damping(0.9);
    const auto h = w.add(body{.shape = sphere{1}, .material = stuff, .velocity = {1, 0, 0}});
    for (int k = 0; k < n; ++k) w.step(1.0 / n);
    CHECK(w[h].velocity()[0] == doctest::Approx(0.9).epsilon(1e-12));
  }
}

TEST_CASE("overlap queries see bodies, globals and planes, and can leave one out") {
  serial::link link;
  world<alone> w(link);
  const auto stuff = w.material({});
  w.global([&](auto& scope) { scope.add(plane{}, stuff); });
  const auto h = w.add(body{.shape = sphere{1}, .position = {0, 0, 5}, .material = stuff});
  CHECK(w.overlaps(sphere{1}, {1.9, 0, 5}));
  CHECK_FALSE(w.overlaps(sphere{1}, {2.1, 0, 5}));
  CHECK_FALSE(w.overlaps(sphere{1}, {0, 0, 5}, {1, 0, 0, 0}, h.id));
  CHECK(w.overlaps(sphere{1}, {9, 0, 0.5}));
  CHECK(w.overlaps(box{{1, 1, 1}}, {9, 0, 0.4}));
  CHECK_FALSE(w.overlaps(box{{1, 1, 1}}, {9, 0, 0.6}));
}

TEST_CASE("a rotation that is none is refused, and one of any length turns by its direction") {
  serial::link link;
  world<alone> w(link);
  const auto h = w.add(box{{1, 2, 3}}, w.material({}));
  refused([&] { w[h].rotate({0, 0, 0, 0}); }, "rotation of body");
  refused([&] { w[h].rotate({bad, 0, 0, 0}); }, "rotation of body");
  refused([&] { w[h].rotate({1, 0, bad, 0}); }, "rotation of body");
  w[h].rotate({2, 0, 0, 2});
  CHECK(w[h].orientation().isApprox(rotation({0, 0, 1}, pi / 2), 1e-12));
}

TEST_CASE("a plane moves and turns about its position like any body") {
  serial::link link;
  world<alone> w(link);
  const auto stuff = w.material({});
  handle<plane> h;
  w.global([&](auto& scope) { h = scope.add(plane{.normal = {0, 0, 2}, .offset = 1}, stuff); });
  w[h].translate({7, 0, 3});
  CHECK(w.overlaps(sphere{1}, {0, 0, 4.9}));
  CHECK_FALSE(w.overlaps(sphere{1}, {0, 0, 5.1}));
  w[h].rotate(rotation({0, 1, 0}, pi / 2));  // the surface is 1 off the position, now along +x
  CHECK(w.overlaps(sphere{1}, {8.9, 0, 50}));
  CHECK_FALSE(w.overlaps(sphere{1}, {9.1, 0, 50}));
}

TEST_CASE("a global body takes no velocity") {
  serial::link link;
  world<alone> w(link);
  const auto stuff = w.material({});
  handle<box> h;
  w.global([&](auto& scope) { h = scope.add(box{{1, 1, 1}}, stuff); });
  refused<std::logic_error>([&] { w[h].set_velocity({1, 0, 0}); }, "global body");
  refused<std::logic_error>([&] { w[h].set_angular_velocity({1, 0, 0}); }, "global body");
}

TEST_CASE("ids of fill never repeat: more fills than there are numbers for is an error") {
  serial::link link;
  world<alone> w(link);
  const auto stuff = w.material({});
  const auto fill = [&] {
    return w.fill(points({{0, 0, 0}}), [&](const site& s) {
      return std::optional(body{.shape = sphere{1}, .position = s.position, .material = stuff});
    });
  };
  for (int k = 0; k < 1 << 14; ++k) w.fill(points({}), [](const site&) { return body{sphere{1}}; });
  refused<std::runtime_error>(fill, "fill was called");
  CHECK(w.local_bodies() == 0);
}

TEST_CASE(
    "the dynamic friction of a material, and of a pair, is the static one unless it is given") {
  material_table table;
  const auto a = table.add({.friction = 0.2}), b = table.add({.friction = 0.6});
  CHECK(table.pair(a, b).dynamic_friction == doctest::Approx(0.4));
  table.set_pair(a, b, {.friction = 0.7});
  CHECK(table.pair(b, a).dynamic_friction == 0.7);
  table.set_pair(a, b, {.friction = 0.7, .dynamic_friction = 0});
  CHECK(table.pair(a, b).dynamic_friction == 0);
}
