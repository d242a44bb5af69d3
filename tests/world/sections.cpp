// Exclusive and global sections, and calls that are forbidden in them.
#include <doctest/doctest.h>

#include <stdexcept>
#include <talus/observe/summary.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/scene/site.hpp>
#include <talus/world/world.hpp>

#include "../scenes/alone.hpp"

using namespace talus;
using scenes::alone;

namespace {

struct small_world {
  serial::link link;
  world<alone> w{link};
  material_id stuff = w.material({});
};

}  // namespace

TEST_CASE("an exclusive section inside an exclusive section is a runtime_error that says so") {
  small_world s;
  s.w.exclusive(0, [&] {
    CHECK_THROWS_WITH_AS(s.w.exclusive(0, [] {}), doctest::Contains("inside another one on rank 0"),
                         std::runtime_error);
  });
}

TEST_CASE("an exclusive section inside a global one, or the reverse, is a logic_error") {
  small_world s;
  s.w.global([&](auto& w) {
    CHECK_THROWS_WITH_AS(w.exclusive(0, [] {}), doctest::Contains("inside a global section"),
                         std::logic_error);
  });
  s.w.exclusive(0, [&] {
    CHECK_THROWS_WITH_AS(s.w.global([](auto&) {}), doctest::Contains("inside an exclusive section"),
                         std::logic_error);
  });
}

TEST_CASE("a global section inside a global section is a runtime_error") {
  small_world s;
  s.w.global([&](auto& w) {
    CHECK_THROWS_WITH_AS(w.global([](auto&) {}), doctest::Contains("inside another one"),
                         std::runtime_error);
  });
}

TEST_CASE("an exclusive section for a rank that does not exist is an invalid_argument") {
  small_world s;
  for (const int rank : {-1, 1, 17})
    CHECK_THROWS_WITH_AS(s.w.exclusive(rank, [] {}), doctest::Contains("this job has 1 rank(s)"),
                         std::invalid_argument);
}

TEST_CASE("collectives in an exclusive section are runtime_errors, serially too") {
  small_world s;
  s.w.exclusive(0, [&] {
    const auto refused = [](auto&& f) {
      CHECK_THROWS_WITH_AS(f(), doctest::Contains("all ranks must take part"), std::runtime_error);
    };
    refused([&] { s.w.step(0.01); });
    refused([&] { s.w.synchronize(); });
    refused([&] { s.w.simulate({.steps = 1, .dt = 0.01}); });
    refused([&] { s.w.check_connections(); });
    refused([&] { s.w.decompose({}); });
    refused([&] { s.w.add_if_local(body{.shape = sphere{1}}); });
    refused([&] { (void)state_digest(s.w); });
    refused([&] { (void)measure_motion(s.w); });
    refused([&] { (void)measure_penetration(s.w); });
    refused([&] { (void)summarize(s.w, 0, 0); });
  });
}

TEST_CASE("sections end with their scope, also when an exception leaves them") {
  small_world s;
  CHECK_THROWS(s.w.exclusive(0, [] { throw 1; }));
  CHECK_THROWS(s.w.global([](auto&) { throw 1; }));
  CHECK_NOTHROW(s.w.exclusive(0, [] {}));
  CHECK_NOTHROW(s.w.global([](auto&) {}));
  if (auto only = s.w.exclusive(0)) CHECK_THROWS(s.w.step(0.01));
  CHECK_NOTHROW(s.w.step(0.01));
}

TEST_CASE("an infinite body outside of a global section is a logic_error") {
  small_world s;
  CHECK_THROWS_WITH_AS(s.w.add(plane{}, s.stuff), doctest::Contains("add it in world.global"),
                       std::logic_error);
}

TEST_CASE(
    "a global body is fixed, cannot be made movable, and is not changed in an exclusive section") {
  small_world s;
  handle<sphere> h;
  s.w.global([&](auto& w) { h = w.add(sphere{1}, s.stuff, {0, 0, 5}); });
  CHECK(s.w[h].is_global());
  CHECK(s.w[h].is_fixed());
  CHECK_FALSE(s.w[h].is_remote());
  CHECK_THROWS_WITH_AS(s.w[h].release(), doctest::Contains("cannot be made movable"),
                       std::logic_error);
  s.w.exclusive(0, [&] {
    CHECK_THROWS_AS(s.w[h].translate({1, 0, 0}), std::logic_error);
    CHECK_THROWS_AS(s.w[h].rotate(rotation({0, 0, 1}, 1)), std::logic_error);
    CHECK_THROWS_AS(s.w.destroy(h), std::logic_error);
  });
  CHECK_NOTHROW(s.w[h].translate({1, 0, 0}));
  CHECK_NOTHROW(s.w.destroy(h));
  CHECK_FALSE(s.w.find(h).has_value());
}

TEST_CASE("fill and add_if_local make no global bodies, and say so in a global section") {
  small_world s;
  s.w.global([&](auto& w) {
    CHECK_THROWS_WITH_AS(w.fill(points({{0, 0, 0}}), [](const site&) { return body{sphere{1}}; }),
                         doctest::Contains("inside a global section"), std::logic_error);
    CHECK_THROWS_WITH_AS(w.add_if_local(body{.shape = sphere{1}}),
                         doctest::Contains("inside a global section"), std::logic_error);
  });
  CHECK(s.w.local_bodies() == 0);
}
