// Moving cuts: the bits stay those of one rank, and the shares become even.
// timeout: 300
#include "balanced_heap.hpp"

#include <talus/parallel/threads.hpp>

namespace {

using heap = corner<threads>;

corner_end on_threads(int ranks, const corner_plan& plan) {
  corner_end end;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    const corner_end mine = run_corner<heap>(link, plan);
    if (link.rank() == 0) end = mine;
  });
  return end;
}

using doctest::Contains;

}  // namespace

TEST_CASE("the bits of one rank, whether cuts move or not, while bodies come and go") {
  for (const corner_plan& course : courses()) {
    CAPTURE(std::string(course.name));
    const std::string one = on_threads(1, course).digest;
    for (const int ranks : {4, 7}) {
      CAPTURE(ranks);
      const corner_end never = on_threads(ranks, course);
      CHECK(never.digest == one);
      CHECK(never.shares.moved == 0);
      for (const corner_plan& plan : moving(course)) {
        CAPTURE(plan.every);
        const corner_end end = on_threads(ranks, plan);
        CHECK(end.digest == one);
        CHECK(end.shares.moved > 10);
        if (plan.by == balance_by::time) continue;
        CHECK(never.shares.after.bodies > 1.2);
        CHECK(end.shares.after.bodies < 1.15);
      }
    }
  }
}

TEST_CASE("shares are told: the worst for which cuts were moved, and now") {
  threads::launch({.ranks = 4}, [&](threads::link& link) {
    world<heap> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
    fill_corner(w, {.name = ""});
    const auto run = [&](int steps) {
      for (int k = 0; k < steps; ++k) w.step(1.0 / 240);
      return measure_balance(w);
    };
    CHECK(std::isnan(measure_balance(w).after.time));
    const load_balance crowded = run(150);
    CHECK(crowded.moved == 0);
    CHECK(crowded.before.bodies == crowded.after.bodies);
    CHECK(crowded.after.bodies > 1.5);
    CHECK(crowded.after.contacts > 1.5);
    CHECK(crowded.after.time >= 1);
    w.balance({.every = 10, .above = 1.1, .by = balance_by::count});
    const load_balance even = run(20);
    CHECK(even.moved >= 1);
    CHECK(even.before.bodies >= crowded.after.bodies);
    CHECK(even.before.contacts > 1.5);
    CHECK(even.before.time >= 1);
    CHECK(even.before.time <= 4);
    CHECK(even.after.bodies < 1.25);
    CHECK(even.after.contacts < crowded.after.contacts);
    CHECK(even.after.time >= 1);
  });
}

TEST_CASE("cuts stay where shares are even enough, or nobody asked") {
  threads::launch({.ranks = 4}, [&](threads::link& link) {
    world<heap> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
    fill_corner(w, {.name = ""});
    w.balance({.every = 2, .above = 3.9, .by = balance_by::count});
    for (int k = 0; k < 6; ++k) w.step(0.001);
    CHECK(w.divided().cuts.empty());
    w.balance({.every = 4, .above = 1, .by = balance_by::count});
    w.step(0.001), w.step(0.001);
    CHECK(w.divided().cuts.empty());
    w.step(0.001);
    CHECK(w.divided().cuts.size() == 3);
    CHECK(w.divided().lower.x == -4);
    // A decomposition that the user sets is the one to continue from.
    w.decompose({.lower = {-4}, .upper = {4}});
    w.balance({.every = 1, .above = 1.001, .by = balance_by::count});
    w.step(0.001);
    for (const bisection_cut& c : w.divided().cuts) CHECK(c.axis == 0);
  });
}

TEST_CASE("what makes no sense is refused, alike on all ranks") {
  const auto refuses = [](auto action, const char* text) {
    CHECK_THROWS_WITH_AS(
        threads::launch({.ranks = 2},
                        [&](threads::link& link) {
                          world<heap> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
                          action(w);
                        }),
        Contains(text), std::exception);
  };
  refuses([](auto& w) { w.balance({.every = 0}); }, "1 or more, and move above");
  refuses([](auto& w) { w.balance({.above = 0.9}); }, "are 1000 and 0.9");
  refuses([](auto& w) { w.balance({.above = NAN}); }, "are 1000 and nan");
  refuses([](auto& w) { w.exclusive(0, [&] { w.balance({}); }); },
          "balance was called inside an exclusive section");
  refuses([](auto& w) { w.exclusive(1, [&] { (void)measure_balance(w); }); },
          "measure_balance was called inside an exclusive section");
}
