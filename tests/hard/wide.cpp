// Wide heavy loads on light bodies, at the default settings.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/force.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/observe/summary.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/solver/direct/elimination_order.hpp>
#include <talus/world/world.hpp>

#include "../scenes/alone.hpp"

using namespace talus;

namespace {

constexpr real dt = 0.005;

struct load {
  int side = 10;       ///< light bodies in a row
  real density = 1e4;  ///< of the plates; light bodies have 1
  real time = 3;
  int plates = 1;      ///< each on a layer of light bodies
  bool boxes = false;  ///< instead of spheres
  real spacing = 1;
  real lowest = 1e-8;   ///< by which the top may have moved
  real balance = 1e-5;  ///< of the force on the floor in one step, as part of the weight
};

template <class Scenario = scenes::alone>
summary hold(const load& l) {
  CAPTURE(l.side);
  CAPTURE(l.density);
  serial::link link;
  world<Scenario> w(link);
  const auto light = w.material({.density = 1, .friction = 0.5});
  const auto heavy = w.material({.density = l.density, .friction = 0.5});
  w.gravity({0, 0, -9.81});
  handle<plane> floor;
  w.global([&](auto& scope) { floor = scope.add(plane{}, light); });
  const real width = l.side * l.spacing;
  handle<box> top;
  for (int k = 0; k < l.plates; ++k) {
    for (int i = 0; i < l.side; ++i)
      for (int j = 0; j < l.side; ++j) {
        const vec3 at{(i + 0.5) * l.spacing - width / 2, (j + 0.5) * l.spacing - width / 2,
                      2 * k + 0.5};
        if (l.boxes)
          w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = at, .material = light});
        else
          w.add_if_local(body{.shape = sphere{0.5}, .position = at, .material = light});
      }
    top = *w.add_if_local(
        body{.shape = box{{width, width, 1}}, .position = {0, 0, 2 * k + 1.5}, .material = heavy});
  }
  real highest = 0, lowest = 0;
  for (int step = 1; step * dt <= l.time + dt / 2; ++step) {
    w.step(dt);
    const real up = w.find(top)->position()[2] - (2 * l.plates - 0.5);
    highest = std::max(highest, up), lowest = std::min(lowest, up);
  }
  const real weight = measure_motion(w).mass * 9.81;
  const real borne = std::abs(contact_force(w, floor)[2]) / weight;
  MESSAGE(l.side * l.side, " under density ", l.density, ": lowered by ", -lowest, ", floor bears ",
          borne, " of the weight");
  CHECK(-lowest < l.lowest);
  CHECK(highest < l.lowest);
  CHECK(std::abs(borne - 1) < l.balance);
  CHECK(measure_penetration(w).max < 10 * l.lowest);
  return summarize(w, 0, 0);
}

}  // namespace

TEST_CASE("a box of up to 1e4 times the density stands still on up to 400 spheres") {
  for (const int side : {4, 8, 10, 20})
    for (const real density : {1e2, 1e3, 1e4})
      hold({.side = side, .density = density, .time = side == 10 ? 3. : 0.5});
}

TEST_CASE("10,000 spheres hold under a box of density 1e4, and what that took is reported") {
  const summary r = hold({.side = 100, .time = 0.1});
  CHECK(r.islands.solved > 0);
  CHECK(r.islands.skipped == 0);
  CHECK(to_text(r).find("on which the iterations stalled, each solved as one\n") !=
        std::string::npos);
  CHECK(to_json(r).find("\"islands_skipped_contacts\": 0") != std::string::npos);
}

TEST_CASE("light boxes, layers between plates and spheres apart hold too") {
  hold({.side = 8, .time = 0.5, .boxes = true});
  hold({.side = 12, .time = 0.5, .plates = 3});
  hold({.side = 20, .time = 0.5, .spacing = 1.05});
}

TEST_CASE("contacts solved in float hold a wide load to the round-off of floats") {
  hold<scenario<bodies<box, sphere, plane>, transport<serial>, precision<mixed_precision>>>(
      {.side = 20, .time = 0.5, .lowest = 1e-5, .balance = 1e-2});
}

TEST_CASE("islands that are too dear are in the summary and the JSON, with their contacts") {
  summary r;
  r.islands = {.solved = 2, .skipped = 3, .skipped_contacts = 4567};
  CHECK(to_text(r).find("warning  groups of contacts that stall") != std::string::npos);
  CHECK(to_text(r).find("4567") != std::string::npos);
  CHECK(to_json(r).find("\"islands_skipped\": 3") != std::string::npos);
  CHECK(to_json(r).find("\"islands_skipped_contacts\": 4567") != std::string::npos);
}

TEST_CASE("islands in which sweeps would not fail get as much in each step as was spent before") {
  detail::island_budget budget;
  constexpr std::size_t contacts = 10'000;
  const auto open = [&] { (void)budget.due(), budget.close(budget.open(contacts)); };
  open();
  const double step = detail::island_budget::spare_per_contact * contacts;
  CHECK(budget.spare() == detail::island_budget::kept_spare_per_contact * contacts);
  budget.spend_spare(budget.spare() + 5 * step);
  CHECK(budget.spare() == 0);
  int steps = 0;
  for (; budget.spare() < step; ++steps) open();
  CHECK(steps == 6);
  CHECK(budget.spent() == 15 * step);
}

TEST_CASE("what is too dear to be solved within the budget is left as it was and counted") {
  detail::island_budget budget;
  CHECK(budget.open(100) == detail::island_budget::least_kept);
  budget.close(0);
  CHECK(budget.due());
  CHECK(budget.open(100) == detail::island_budget::least);
  budget.skip(70);
  budget.skip(50);
  CHECK(budget.skipped() == 2);
  CHECK(budget.skipped_contacts() == 70);
  // A lattice in space has fill-in, a plate on many bodies has none.
  detail::sparse_graph arrow;
  for (int i = 0; i < 1000; ++i) arrow.column.push_back(1000), arrow.start.push_back(i + 1);
  for (int i = 0; i < 1000; ++i) arrow.column.push_back(i);
  arrow.start.push_back(2000);
  CHECK(detail::elimination_order(arrow, 1e9).cost() < 5000);
  CHECK_FALSE(detail::elimination_order(arrow, 1000).possible());
}
