// timeout: 300
// Extreme input, on one rank and on several: each case either works correctly or ends with a
// message that names the body, its rank, the step and the value. Nothing hangs, no body is lost.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

constexpr real infinity = std::numeric_limits<real>::infinity();
constexpr real not_a_number = std::numeric_limits<real>::quiet_NaN();

template <class Transport>
using row = scenario<bodies<sphere, box, plane>, transport<Transport>,
                     decomposition<grid<dynamic, 1, 1>>, features<forces>>;

/// A world of domains of length 1 that meet at x = 1, 2, ...; the message that ended its steps, or
/// "". With `keeps`, all bodies must be present and finite afterwards.
template <class Transport>
using on_world = std::function<void(world<row<Transport>>&)>;
template <class Transport>
std::string run(int ranks, real dt, int steps, const on_world<Transport>& set_up,
                const on_world<Transport>& each) {
  try {
    Transport::launch({.ranks = ranks}, [&](typename Transport::link& link) {
      world<row<Transport>> w(link, {.lower = {0}, .upper = {1.0 * ranks}});
      w.material({.restitution = 0.3, .friction = 0.4});
      set_up(w);
      w.synchronize();
      const auto before = w.audit();
      for (int k = 0; k < steps; ++k) {
        each(w);
        w.step(dt);
      }
      const auto after = w.audit();
      CHECK(after == before);
      w.for_each_local([&](const auto& b) {
        CHECK(detail::finite(b.position()));
        CHECK(detail::finite(b.velocity()));
        CHECK(detail::finite(b.angular_velocity()));
      });
    });
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

/// The same on one rank without others, and on 1, 2, 4 and 9: check(message, ranks).
using on_message = std::function<void(const std::string& text, int ranks)>;
template <class SetUp, class Each>
void on_all(real dt, int steps, const SetUp& set_up, const Each& each, const on_message& check) {
  const auto look = [&](const std::string& text, int ranks) {
    CAPTURE(ranks);
    CAPTURE(text);
    check(text, ranks);
  };
  look(run<serial>(1, dt, steps, set_up, each), 1);
  for (const int ranks : {1, 2, 4, 9}) look(run<threads>(ranks, dt, steps, set_up, each), ranks);
}
template <class SetUp>
void on_all(real dt, int steps, const SetUp& set_up, const on_message& check) {
  on_all(
      dt, steps, set_up, [](auto&) {}, check);
}

bool says(const std::string& text, std::initializer_list<const char*> words) {
  bool all = true;
  for (const char* word : words) all = all && text.find(word) != std::string::npos;
  return all;
}

template <class World>
void a_few(World& w) {
  for (int k = 0; k < 8; ++k)
    w.add_if_local(body{.shape = sphere{0.1}, .position = {0.1 + 0.35 * k, 0.01 * k, 0}});
}
constexpr real dt = 0.01;

}  // namespace

TEST_CASE("a time step of 0, below 0, infinite or not a number is refused on every rank") {
  for (const real wrong : {0.0, -0.01, infinity, not_a_number})
    on_all(
        wrong, 3, [](auto& w) { a_few(w); },
        [](const std::string& text, int) {
          CHECK(says(text, {"the time step dt must be positive and finite"}));
        });
}

TEST_CASE("gravity, velocities, forces, places and sizes that are no numbers are refused at once") {
  for (const real wrong : {infinity, -infinity, not_a_number}) {
    const auto refused = [&](auto&& f, const char* what) {
      on_all(
          dt, 3, [&](auto& w) { f(w); },
          [&](const std::string& text, int) {
            CHECK(says(text, {what, "finite"}));
          });
    };
    refused([&](auto& w) { w.gravity({0, 0, wrong}); }, "gravity");
    refused(
        [&](auto& w) {
          w.add_if_local(body{.shape = sphere{1}, .position = {wrong, 0, 0}});
        },
        "position");
    refused(
        [&](auto& w) {
          w.add_if_local(body{.shape = sphere{1}, .velocity = {0, wrong, 0}});
        },
        "velocity");
    refused(
        [&](auto& w) {
          w.add_if_local(body{.shape = sphere{1}, .angular_velocity = {0, wrong, 0}});
        },
        "angular velocity");
    refused([&](auto& w) { w.add_if_local(body{.shape = sphere{wrong}}); }, "radius");
    refused([&](auto& w) { w.add_if_local(body{.shape = box{{1, wrong, 1}}}); }, "y edge");
    refused([&](auto& w) { w.material({.density = wrong}); }, "density");
    refused([&](auto& w) { w.material({.friction = std::abs(wrong)}); }, "friction");
    refused(
        [&](auto& w) {
          a_few(w);
          w.for_each_local([&](auto& b) { b.add_force({wrong, 0, 0}); });
        },
        "force");
  }
}

TEST_CASE("sizes of 1e-300 and 1e300 are refused by name, and what numbers can hold works") {
  for (const real size : {1e-300, 1e-103, 1e-70, 1e70, 1e103, 1e300})
    on_all(
        dt, 3,
        [&](auto& w) {
          w.add_if_local(body{.shape = sphere{size}, .position = {0.5, 0, 0}});
          w.add_if_local(body{.shape = box{{size, size, size}}, .position = {0.5, 5, 0}});
        },
        [&](const std::string& text, int) { CHECK(says(text, {"beyond what numbers can hold"})); });
  for (const real size : {1e-50, 1e-9, 1e6, 1e50})
    on_all(
        dt, 3,
        [&](auto& w) {
          w.add_if_local(body{.shape = sphere{size}, .position = {0, 0, 0}});
        },
        [&](const std::string& text, int ranks) {
          if (size > 1 && ranks > 2)  // it reaches into domains that are not connected to its own
            CHECK(says(text, {"contacts there would be lost"}));
          else
            CHECK(text == "");
        });
  for (const real density : {1e-300, 1e300})
    on_all(
        dt, 3,
        [&](auto& w) {
          w.add_if_local(body{.shape = sphere{0.01},
                              .position = {0.5, 0, 0},
                              .material = w.material({.density = density})});
        },
        [&](const std::string& text, int) {
          CHECK((density > 1 ? text == "" : says(text, {"beyond what numbers can hold"})));
        });
  on_all(
      dt, 3,
      [](auto& w) {
        w.add_if_local(body{.shape = sphere{1e-15}, .position = {0.5, 0, 0}});
      },
      [](const std::string& text, int) {
        CHECK(says(text, {"body 0x4000000000000000 at (0.5, 0, 0) on rank 0",
                          "cannot be placed in step 0", "lost in rounding"}));
      });
}

TEST_CASE("what becomes infinite in the run ends it with body, rank, step and value") {
  // By gravity, in the second step.
  on_all(
      1e6, 100,
      [](auto& w) {
        a_few(w), w.gravity({0, 0, -1e300});
      },
      [](const std::string& text, int) {
        CHECK(says(text, {"the position of body 0x4", "rank ", "is no longer finite in step 0",
                          "-inf", "dt = 1000000"}));
      });
  // By a force on a body of one rank.
  on_all(
      dt, 100, [](auto& w) { a_few(w); },
      [](auto& w) {
        if (w.steps() == 5)
          if (const auto b = w.find(handle<sphere>{detail::id_of_attempt(4)}); b && !b->is_remote())
            for (int k = 0; k < 2; ++k) w[b->handle()].add_force({0, 1.7e308, 0});
      },
      [](const std::string& text, int ranks) {
        CHECK(says(text, {"the velocity of body 0x4000000000000004", "(sphere)",
                          ranks == 1   ? "rank 0"
                          : ranks == 2 ? "rank 1"
                                       : "rank 1",
                          "is no longer finite in step 5", "inf", "dt = 0.01"}));
      });
  // By a spin that no orientation can follow.
  on_all(
      dt, 10,
      [](auto& w) {
        w.add_if_local(body{.shape = box{{0.1, 0.2, 0.1}},
                            .position = {0.5, 0, 0},
                            .angular_velocity = {1e200, 0, 1}});
      },
      [](const std::string& text, int) {
        CHECK(says(text, {"body 0x4000000000000000 at (0.5, 0, 0) on rank 0", "(1e+200, 0, 1)",
                          "dt = 0.01", "cannot be placed in step 0",
                          "the reach inf is not a finite length", "smaller dt"}));
      });
}

TEST_CASE("bodies at 1e9, 1e30 and 1e200 lengths per time fly rightly, or are named") {
  for (const real speed : {1e9, 1e30, 1e200})
    for (const bool outwards : {true, false})
      on_all(
          dt, 20,
          [&](auto& w) {
            if (!outwards) a_few(w);
            w.add_if_local(body{.shape = sphere{0.1},
                                .position = {0.5, 3, 0},
                                .velocity = {outwards ? -speed : speed, 0, 0}});
          },
          [&](const std::string& text, int ranks) {
            // Outside of the scene no body can be missed; motion into domains that are not
            // connected is refused before it happens. Far greater speeds are below the precision of
            // the position, or have no finite square.
            if (speed > 1e10)
              CHECK(((text == "" && speed < 1e100) ||
                     says(text, {"body 0x4", "in step ", "dt = 0.01"})));
            else if (!outwards && ranks > 2)
              CHECK(says(text, {"body 0x4000000000000008 of rank 0 at (0.5, 3, 0) would fly",
                                "in step 0", "contacts on its way would be lost"}));
            else
              CHECK(text == "");
          });
}

TEST_CASE("a body that flies past its neighbourhood in a step that did not show it is named") {
  on_all(
      dt, 5, [](auto& w) { a_few(w); },
      [](auto& w) {
        // Through a force, which acts in the step itself.
        if (w.steps() == 2)
          if (const auto b = w.find(handle<sphere>{detail::id_of_attempt(0)}); b && !b->is_remote())
            w[b->handle()].add_force({1e5, 0, 0});
      },
      [](const std::string& text, int ranks) {
        if (ranks > 2)
          CHECK(says(text, {"body 0x4000000000000000 of rank 0 flew from", "in step 3",
                            "to which rank 0 is not connected"}));
        else
          CHECK(text == "");
      });
}

TEST_CASE("bodies exactly in each other part with finite speed and none is lost") {
  on_all(
      dt, 50,
      [](auto& w) {
        for (int k = 0; k < 6; ++k) {
          w.add_if_local(body{.shape = sphere{0.3}, .position = {1, 0, 0}});
          w.add_if_local(body{.shape = box{{0.4, 0.4, 0.4}}, .position = {0.5, 0, 0}});
          w.add_if_local(body{.shape = sphere{0.2}, .position = {0.5, 0, 0}});
        }
        w.global([](auto& s) { s.add(box{{1, 1, 1}}, material_id{}, vec3(0.5, 0, 0)); });
      },
      [](const std::string& text, int) { CHECK(text == ""); });
}

TEST_CASE("a rank that throws, or returns, while others step ends the run on all of them") {
  for (const int ranks : {2, 4, 9}) {
    CAPTURE(ranks);
    const auto set_up = [](auto& w) { a_few(w); };
    const int last = ranks - 1;
    CHECK(run<threads>(ranks, dt, 50, set_up, [&](auto& w) {
            if (w.rank() == last && w.steps() == 7) throw std::runtime_error("no more");
          }) == "no more");
    try {
      threads::launch({.ranks = ranks}, [&](auto& link) {
        world<row<threads>> w(link, {.lower = {0}, .upper = {1.0 * ranks}});
        w.material({});
        a_few(w);
        for (int k = 0; k < 50; ++k) {
          if (w.rank() == last && k == 7) return;
          w.step(dt);
        }
      });
      CHECK(false);
    } catch (const std::exception& e) {
      CHECK(says(e.what(), {"every rank waits for another one", "has ended"}));
    }
  }
}
