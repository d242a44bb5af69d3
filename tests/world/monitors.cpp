// The monitors: their values for scenes with closed forms, closure to round-off in every step on
// any number of ranks, and no effect on the trajectory.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <talus/observe/force.hpp>
#include <talus/observe/progress.hpp>
#include <talus/observe/summary.hpp>
#include <talus/observe/time_series.hpp>
#include <type_traits>

#include "monitored_pile.hpp"

using namespace talus;
using namespace monitored;

namespace {

using watched_euler =
    soft_scene<rolling_springs, semi_implicit_euler, energy_ledger, momentum_balance>;
using watched_verlet = soft_scene<hertz_springs, velocity_verlet, energy_ledger, momentum_balance>;

// Without a monitor nothing is stored.
static_assert(std::is_empty_v<detail::monitor_records<type_list<forces, damping>>>);

/// Runs `program(world)` on one rank.
template <class Program>
void alone(Program&& program) {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<watched> w(link);
    w.gravity({0, 0, -g});
    program(w);
  });
}

/// Makes a step; the ledger must close in it. Its values are correct on all ranks.
template <class World>
energy_balance watched_step(World& w, real length = dt) {
  w.step(length);
  const energy_balance e = measure_energy(w);
  const momentum_account m = measure_momentum(w);
  REQUIRE(e.error() < round_off);
  REQUIRE(m.error() < 1e-11);
  REQUIRE(e.kinetic + e.potential + e.elastic ==
          doctest::Approx(e.initial + e.changes + e.total.net()).epsilon(1e-12));
  return e;
}

void add_floor(world<watched>& w, material_id stuff) {
  w.global([&](auto& scope) { scope.add(plane{}, stuff); });
}

/// The values of a run of such a pile on rank 0, checked in every step.
template <class Scenario>
energy_balance watch_soft_pile(int ranks) {
  energy_balance last;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, cells());
    set_up_pile(w);
    if (const auto belt =
            w.add_if_local(body{.shape = sphere{1.5}, .position = {0, 0, -0.8}, .fixed = true}))
      w[*belt].set_velocity({1, 0, 0.2}), w[*belt].set_angular_velocity({0, 2, 1});
    w.synchronize();
    energy_balance b;
    for (int k = 0; k < 600; ++k) b = watched_step(w, dt / 3);
    if (w.rank() == 0) last = b;
  });
  return last;
}

}  // namespace

TEST_CASE("a free fall loses m g^2 dt^2 / 2 to the scheme in each step, and nothing else") {
  alone([](auto& w) {
    const auto stuff = w.material({.density = 2});
    const auto ball = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 9}, .material = stuff});
    const real mass = w[ball].mass();
    for (int k = 0; k < 100; ++k) {
      const energy_flows step = watched_step(w).step;
      CHECK(step.scheme == doctest::Approx(-0.5 * mass * g * g * dt * dt).epsilon(1e-10));
      CHECK(step.net() == step.scheme);
    }
  });
}

TEST_CASE("an impact dissipates m (v - v') (v + v' + g dt) / 2, and v' = e v to within 2 g dt") {
  alone([](auto& w) {
    const real e = 0.6;
    const auto stuff = w.material({.restitution = e});
    add_floor(w, stuff);
    const auto ball = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 1.5}, .material = stuff});
    const real mass = w[ball].mass();
    int impacts = 0;
    real v = 0;
    for (int k = 0; k < 600; ++k) {
      const real before = w[ball].velocity()[2];
      const energy_balance b = watched_step(w);
      CHECK(b.step.impact > -1e-14);
      CHECK(b.step.friction == 0);
      if (!(before < -0.5 && w[ball].velocity()[2] > 0)) continue;
      ++impacts;
      v = -before;
      const real after = w[ball].velocity()[2];
      CHECK(std::abs(after - e * v) <= 2 * g * dt);
      CHECK(b.step.impact == doctest::Approx(0.5 * mass * (v - after) * (v + after + g * dt)));
    }
    CHECK(impacts >= 3);
    const energy_balance b = measure_energy(w);
    MESSAGE("of ", b.initial - mass * g * 0.5, " J the impacts took ", b.total.impact,
            ", the scheme ", -b.total.scheme, ", the correction gave ", b.total.correction);
    CHECK(b.worst < round_off);
  });
}

TEST_CASE("a sliding block turns its kinetic energy into friction, mu m g over its way") {
  alone([](auto& w) {
    const real mu = 0.3, v0 = 3;
    const auto stuff = w.material({.density = 2, .friction = mu});
    add_floor(w, stuff);
    const auto block = w.add(body{.shape = box{{1, 1, 0.2}},
                                  .position = {0, 0, 0.1},
                                  .material = stuff,
                                  .velocity = {v0, 0, 0}});
    const real mass = w[block].mass();
    energy_balance b;
    for (int k = 0; k < 400; ++k) b = watched_step(w);
    const real way = w[block].position()[0];
    MESSAGE("friction took ", b.total.friction, " of ", 0.5 * mass * v0 * v0);
    CHECK(w[block].velocity().norm() < 1e-9);
    CHECK(b.total.friction == doctest::Approx(0.5 * mass * v0 * v0).epsilon(1e-6));
    // The scheme moves a step with the velocity at its end, friction works at the mean one.
    CHECK(b.total.friction == doctest::Approx(mu * mass * g * (way + 0.5 * dt * v0)).epsilon(1e-5));
    CHECK(std::abs(b.total.impact) < 1e-6 * b.total.friction);
  });
}

TEST_CASE("a belt works twice what the box on it gains; the other half goes to friction") {
  alone([](auto& w) {
    const real v = 2;
    const auto stuff = w.material({.friction = 0.5});
    const auto belt = w.add(
        body{.shape = box{{40, 4, 1}}, .position = {0, 0, -0.5}, .material = stuff, .fixed = true});
    w[belt].set_velocity({v, 0, 0});
    const auto load =
        w.add(body{.shape = box{{1, 1, 0.2}}, .position = {0, 0, 0.1}, .material = stuff});
    const real mass = w[load].mass();
    energy_balance b;
    for (int k = 0; k < 300; ++k) b = watched_step(w);
    CHECK(w[load].velocity()[0] == doctest::Approx(v).epsilon(1e-6));
    CHECK(b.total.work == doctest::Approx(mass * v * v).epsilon(1e-6));
    CHECK(b.total.friction == doctest::Approx(0.5 * mass * v * v).epsilon(1e-6));
    CHECK(measure_momentum(w).borne_weight() == doctest::Approx(1).epsilon(1e-6));
  });
}

TEST_CASE("a free top changes its energy by the scheme of rotation alone") {
  alone([](auto& w) {
    w.gravity({0, 0, 0});
    w.material({});
    w.add(body{.shape = box{{1, 2, 0.3}}, .angular_velocity = {5, 5e-3, 0}});
    for (int k = 0; k < 1000; ++k) {
      const energy_balance b = watched_step(w);
      CHECK(b.step.net() == b.step.scheme);
    }
    const energy_balance b = measure_energy(w);
    CHECK(b.kinetic - b.initial == doctest::Approx(b.total.scheme).epsilon(1e-9));
  });
}

TEST_CASE("forces and torques of the user work, and damping takes (1 - kept^2) of what there is") {
  alone([](auto& w) {
    w.gravity({0, 0, 0});
    w.material({});
    w.damping(0.5);
    const auto ball = w.add(body{.shape = sphere{0.5}, .velocity = {1, 2, 0}});
    const real mass = w[ball].mass(), inertia = w[ball].inertia()[0];
    const vec3 force(3, 0, 0), torque(0, 0, 0.2);
    real kinetic = measure_energy(w).kinetic;
    CHECK(kinetic == doctest::Approx(0.5 * mass * 5));
    for (int k = 0; k < 50; ++k) {
      const vec3 v = w[ball].velocity(), spin = w[ball].angular_velocity();
      w[ball].add_force(force);
      w[ball].add_torque(torque);
      const energy_balance b = watched_step(w);
      const real work = dt * force.dot(v) + 0.5 * dt * dt * force.squaredNorm() / mass +
                        dt * torque.dot(spin) + 0.5 * dt * dt * torque.squaredNorm() / inertia;
      CHECK(b.step.work == doctest::Approx(work).epsilon(1e-12));
      CHECK(b.step.damping ==
            doctest::Approx((1 - std::pow(0.5, 2 * dt)) * (kinetic + work)).epsilon(1e-12));
      kinetic = b.kinetic;
    }
    w[ball].set_velocity({0, 0, 0});
    const energy_balance b = measure_energy(w);
    CHECK(b.changes < -1);
    CHECK(b.kinetic == doctest::Approx(b.initial + b.changes + b.total.net()).epsilon(1e-12));
  });
}

TEST_CASE(
    "a pile of spheres and boxes with restitution, damping, forces and a belt: the books close in "
    "every step on 1 and 4 ranks") {
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<watched> w(link, cells());
      set_up_pile(w);
      w.synchronize();
      energy_balance b;
      double momentum = 0;
      for (int k = 0; k < 300; ++k) {
        push_some(w);
        b = watched_step(w);
        momentum = std::max(momentum, measure_momentum(w).error());
      }
      CHECK(b.worst < round_off);
      for (const double entry :
           {b.total.work, b.total.friction, b.total.impact, b.total.damping, b.total.correction})
        CHECK(entry > 0);
      if (w.rank() != 0) return;
      MESSAGE(ranks, " rank(s): closure ", b.worst, ", momentum ", momentum, "; initial ",
              b.initial, ", now ", b.kinetic + b.potential, ", work ", b.total.work, ", friction ",
              b.total.friction, ", impact ", b.total.impact, ", damping ", b.total.damping,
              ", correction ", b.total.correction, ", scheme ", b.total.scheme);
    });
  }
}

TEST_CASE("the impact of two soft spheres takes what restitution says, whatever the integrator") {
  const auto impact = [&]<class Scenario>(Scenario) {
    energy_balance b;
    threads::launch({.ranks = 1}, [&](threads::link& link) {
      world<Scenario> w(link, cells());
      const auto stuff = w.material({.restitution = 0.6, .stiffness = 500, .youngs_modulus = 2e4});
      for (const real side : {-1.0, 1.0})
        w.add(body{.shape = sphere{0.5},
                   .position = {0.51 * side, 0, 0},
                   .material = stuff,
                   .velocity = {-0.5 * side, 0, 0}});
      for (int k = 0; k < 400; ++k) b = watched_step(w);
    });
    MESSAGE("impact ", b.total.impact / b.initial, " of the energy, scheme ",
            b.total.scheme / b.initial);
    CHECK(b.elastic == 0);
    CHECK(b.total.friction == 0);
    CHECK(b.total.impact == doctest::Approx((1 - 0.6 * 0.6) * b.initial).epsilon(0.02));
    CHECK(std::abs(b.total.scheme) < 0.02 * b.initial);
    return b;
  };
  impact(watched_euler{});
  impact(watched_verlet{});
}

TEST_CASE("the books of soft contacts close in every step too, on 1 and 4 ranks") {
  const auto watch = [&]<class Scenario>(Scenario) {
    for (const int ranks : {1, 4}) {
      CAPTURE(ranks);
      const energy_balance b = watch_soft_pile<Scenario>(ranks);
      CHECK(b.worst < round_off);
      CHECK(b.elastic > 0);
      for (const double entry : {b.total.work, b.total.friction, b.total.impact, b.total.damping})
        CHECK(entry > 0);
      CHECK(std::abs(b.total.scheme) < 0.2 * b.total.friction);
      MESSAGE(ranks, " rank(s): closure ", b.worst, "; initial ", b.initial, ", now ",
              b.kinetic + b.potential, " and ", b.elastic, " in springs; work ", b.total.work,
              ", friction ", b.total.friction, ", impact ", b.total.impact, ", damping ",
              b.total.damping, ", scheme ", b.total.scheme);
    }
  };
  watch(watched_euler{});
  watch(watched_verlet{});
}

TEST_CASE("no passive scene gains energy; at rest the floor bears the weight above it") {
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<watched> w(link, cells());
      w.gravity({0, 0, -g});
      const auto stuff = w.material({.restitution = 0.3, .friction = 0.5});
      handle<plane> ground;
      w.global([&](auto& scope) { ground = scope.add(plane{}, stuff); });
      w.fill(
          simple_cubic{.spacing = 1.02, .origin = {0.1, 0.1, 0.5}} &
              box_region{{-2.5, -2.5, 0}, {2.5, 2.5, 2}},
          [&](const site& place) {
            return body{.shape = box{{1, 0.9, 1}}, .position = place.position, .material = stuff};
          });
      energy_balance b = measure_energy(w);
      double last = b.kinetic + b.potential, rise = 0, gain = 0;
      for (int k = 0; k < 500; ++k) {
        b = watched_step(w);
        const double now = b.kinetic + b.potential;
        rise = std::max(rise, (now - last - b.step.correction) / b.scale);
        gain = std::max(gain, -(b.step.friction + b.step.impact) / b.scale);
        last = now;
      }
      const momentum_account m = measure_momentum(w);
      const vec3 on_ground = contact_force(w, ground);  // all ranks call it alike
      const force_balance balance = measure_force_balance(w);
      if (w.rank() != 0) return;
      CHECK(balance.borne == doctest::Approx(m.borne_weight()).epsilon(1e-9));
      CHECK(balance.change == doctest::Approx(balance.borne - 1).epsilon(1e-9));
      CHECK(balance.error < 1e-11);
      CHECK(balance.unstopped < 1e-3);
      MESSAGE(ranks, " rank(s): largest rise of the energy in a step, relative ", rise,
              "; by contacts ", gain, "; borne weight - 1 = ", m.borne_weight() - 1, "; scheme ",
              b.total.scheme, ", correction ", b.total.correction, ", impact ", b.total.impact,
              ", friction ", b.total.friction);
      CHECK(b.kinetic + b.potential < b.initial);
      CHECK(rise < 1e-7);  // the residue of iterations in impulses between resting bodies
      CHECK(m.borne_weight() == doctest::Approx(1).epsilon(1e-6));
      CHECK(on_ground[2] == doctest::Approx(-m.mass * g * m.borne_weight()).epsilon(1e-12));
    });
  }
}

TEST_CASE("monitors change no trajectory by a bit, on 1 and 4 ranks") {
  for (const int ranks : {1, 4})
    CHECK(digest_of_pile<watched>(ranks) == digest_of_pile<plain>(ranks));
}

TEST_CASE(
    "the summary and its JSON file have what the monitors say, and so has the progress line") {
  alone([](auto& w) {
    const auto stuff = w.material({.restitution = 0.5});
    add_floor(w, stuff);
    w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0.6}, .material = stuff});
    for (int k = 0; k < 100; ++k) w.step(dt);
    const summary r = summarize(w, 0, 0);
    const std::string json = to_json(r), text = to_text(r);
    const energy_balance b = measure_energy(w);
    for (const auto& [name, value] : {std::pair{"energy_impact", b.total.impact},
                                      {"energy_error", b.error()},
                                      {"energy_error_worst", b.worst},
                                      {"borne_weight", measure_momentum(w).borne_weight()},
                                      {"momentum_error", measure_momentum(w).error()},
                                      {"overlap_worst", measure_overlaps(w).worst}}) {
      CAPTURE(name);
      CHECK(json.find("\"" + std::string(name) + "\": " + detail::text(value)) !=
            std::string::npos);
    }
    // Once, and in words.
    for (const std::string& words :
         {"\n  overlap  deepest in any step: " +
              detail::text(measure_overlaps(w).worst * r.overlap.mean_radius, 3) + "\n",
          "impacts " + detail::text(b.total.impact, 3) + ", damping ",
          "but for " + detail::text(b.worst, 2) + " of what a step exchanges\n",
          "in the last step is accounted for, but for " +
              detail::text(measure_momentum(w).error(), 2) + " of it\n"}) {
      CAPTURE(words);
      CAPTURE(text);
      CHECK(text.find(words) != std::string::npos);
    }
    const std::string note = measure_monitors(w).text;
    CHECK(note.find(", energy ") != std::string::npos);
    std::FILE* out = std::tmpfile();
    progress_line(out).finish(100, note);
    std::rewind(out);
    std::string line(200, '\0');
    line.resize(std::fread(line.data(), 1, line.size(), out));
    std::fclose(out);
    MESSAGE(line);
    CHECK(line.find("step 100 of 100") == 0);
    CHECK(line.find(note) != std::string::npos);
  });
}

TEST_CASE("the monitor of overlaps sees what geometry sees, one step later") {
  alone([](auto& w) {
    set_up_pile(w);
    double worst = 0;
    for (int k = 0; k < 100; ++k) {
      const penetration p = measure_penetration(w);
      worst = std::max(worst, p.max);
      watched_step(w);
      const overlap_account o = measure_overlaps(w);
      CHECK(o.mean == doctest::Approx(p.mean).epsilon(1e-12));
      CHECK(o.max == doctest::Approx(p.max).epsilon(1e-12));
      CHECK(o.worst == doctest::Approx(worst).epsilon(1e-12));
    }
    CHECK(worst > 0);
  });
}

TEST_CASE("a time series has a line for each sample, at once, and the same columns on any ranks") {
  const std::string file = "monitors_time_series.csv";
  const auto lines_of = [&] {
    std::vector<std::string> lines;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  };
  std::string head;
  for (const int ranks : {1, 4}) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<watched> w(link, cells());
      set_up_pile(w);
      time_series table(file, w.rank() == 0);
      w.before_simulating([&] { table.sample(w); });
      w.after_each_step([&] {
        if (w.steps() % 5 != 0) return;
        table.sample(w);
        if (w.rank() == 0) CHECK(lines_of().size() == 2 + w.steps() / 5);
      });
      w.simulate({.steps = 20, .dt = dt});
      table.sample(w);
      const energy_balance b = measure_energy(w);
      if (w.rank() != 0) return;
      const auto lines = lines_of();
      REQUIRE(lines.size() == 6);
      if (head.empty()) head = lines[0];
      CHECK(lines[0] == head);
      std::istringstream names(lines[0]), values(lines[5]);
      std::vector<std::string> name, value;
      for (std::string word; std::getline(names, word, ',');) name.push_back(word);
      for (std::string word; std::getline(values, word, ',');) value.push_back(word);
      REQUIRE(name.size() == value.size());
      const auto column = [&](const std::string& wanted) {
        const auto at = std::find(name.begin(), name.end(), wanted);
        REQUIRE(at != name.end());
        return std::stod(value[static_cast<std::size_t>(at - name.begin())]);
      };
      CHECK(column("step [1]") == 20);
      CHECK(column("time [T]") == w.time());
      CHECK(column("kinetic_energy [M L^2/T^2]") == doctest::Approx(b.kinetic).epsilon(1e-14));
      CHECK(column("energy_friction [M L^2/T^2]") == b.total.friction);
      CHECK(column("energy_error [1]") < round_off);
      CHECK(column("bodies [1]") > 100);
    });
  }
  std::remove(file.c_str());
  CHECK_THROWS_WITH_AS(time_series("no_such_folder/a.csv", true),
                       doctest::Contains("name a file in a folder that exists"),
                       std::runtime_error);
  CHECK_NOTHROW(time_series("no_such_folder/a.csv", false));
}
