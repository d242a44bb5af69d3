// The estimate of --dry-run: contacts at rest beside those of the run itself, on one, two and four
// ranks, and the time of runs whose steps have known times.
#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <talus/scene/dry_run.hpp>
#include <talus/talus.hpp>

using namespace talus;

namespace {

using columns_of_space = grid<dynamic, dynamic>;
using grains = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
                        decomposition<columns_of_space>, transport<threads>>;

/// 64 spheres, `layers` on each other, which fall.
template <class World>
void fill_with_spheres(World& w, int layers) {
  w.material({.density = 2, .friction = 0.5});
  w.gravity({0, 0, -10});
  const int rows = layers == 1 ? 8 : 4;
  w.global([&](auto& scope) {
    scope.add(plane{}, {});
    for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
      scope.add(plane{.normal = n, .offset = -0.55 * rows}, {});
  });
  for (int k = 0; k < 64; ++k) {
    const auto x = static_cast<real>(k % rows), y = static_cast<real>(k / rows % rows),
               z = static_cast<real>(k / rows / rows);
    w.add_if_local(body{.shape = sphere{0.45},
                        .position = {1.1 * (x - 0.5 * (rows - 1)) + 0.05 * z,
                                     1.1 * (y - 0.5 * (rows - 1)) - 0.03 * z, 2 + 1.3 * z}});
  }
  w.synchronize();
}

/// 1000 bodies that fall for 2000 of 10000 steps; each takes 1 microsecond, and a contact 4.
detail::run_estimate falling() {
  detail::run_estimate e;
  e.bodies = e.movable = 1000;
  e.steps = 10000;
  e.gravity = e.falls = true;
  e.steps_of_fall = 2000;
  return e;
}
detail::trial_part part_of(std::uint64_t steps, double before, double after) {
  const double time = 1e-6 * 1000 + 4e-6 * 0.5 * (before + after);
  return {steps, static_cast<double>(steps) * time, static_cast<std::uint64_t>(after)};
}

/// The estimate of a call of simulate() that a trial measures.
template <class World>
detail::run_estimate estimate_of_call(World& w, std::uint64_t steps, real dt) {
  struct shared {
    detail::call_trial<typename World::scenario_type> trial{};
    detail::run_estimate found{};
    bool on = true;
  };
  const auto all = std::make_shared<shared>();
  w.before_simulating([&w, all] {
    if (all->on) all->trial.begin(w);
  });
  w.monitor_after_observers("trial", [&w, all] {
    if (!all->on || !all->trial.end_step(w)) return;
    all->found = all->trial.estimate(w);
    if (w.steps() < w.last_step()) w.stop();
  });
  w.simulate({.steps = steps, .dt = dt});
  all->on = false;
  return all->found;
}

/// 27 spheres at rest, apart from each other and without gravity, which `field` accelerates.
template <class World>
void fill_without_gravity(World& w) {
  w.material({.density = 2, .friction = 0.5});
  for (int k = 0; k < 27; ++k)
    w.add_if_local(body{.shape = sphere{0.45},
                        .position = {1.2 * (k % 3 - 1), 1.2 * (k / 3 % 3 - 1), 1.2 * (k / 9 - 1)}});
  w.synchronize();
}

using attracted =
    scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
             decomposition<columns_of_space>, transport<threads>, features<forces>>;

}  // namespace

TEST_CASE("the trial of a dry run has the forces of fields, whose names it gives") {
  for (const int ranks : {1, 2})
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      CAPTURE(ranks);
      world<attracted> w(link, columns_of_space{.lower = {-5, -5}, .upper = {5, 5}});
      fill_without_gravity(w);
      add_force_field(
          w, [](const vec3& x, real) { return -4 * x; }, "attraction");
      const detail::run_estimate e = estimate_of_call(w, 240, 1.0 / 120);
      CHECK(e.contacts() > 27);
      const std::string text = detail::to_text(e, "grains");
      CHECK(text.find("there is no gravity") == text.npos);
      CHECK((e.settled() || text.find("\"attraction\"") != text.npos));
    });
}

TEST_CASE("the trial of a dry run calls observers, and ends where they end the call") {
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<grains> w(link, columns_of_space{.lower = {-5, -5}, .upper = {5, 5}});
    fill_with_spheres(w, 1);
    int calls = 0;
    w.observe(every{1}, [&](auto&) { ++calls; });
    w.stop_when(every{10}, [](auto& world) { return world.steps() >= 40; });
    const detail::run_estimate e = estimate_of_call(w, 100, 1.0 / 240);
    CHECK(calls == 40);
    CHECK(e.steps == 40);
    CHECK(detail::to_text(e, "grains")
              .find("for the 40 steps of this call of simulate(), which "
                    "ends early in the trial") != std::string::npos);
  });
}

TEST_CASE("a dry run takes the time of a contact from the trial") {
  detail::run_estimate e = falling();
  double contacts = 0;
  for (int k = 0; k < 10; ++k, contacts += 100)
    e.trial.push_back(part_of(100, k == 0 ? 0 : contacts - 100, contacts));
  CHECK(e.contacts() == 900);
  CHECK_FALSE(e.settled());
  CHECK(e.contacts_at_rest() == 3000);
  const double at_rest = 1e-3 + 4e-6 * 3000;
  CHECK(e.step_at_rest() == doctest::Approx(at_rest).epsilon(0.1));
  // 1000 steps of the trial, 1000 of the fall, 8000 at rest.
  const double time = e.trial_seconds() + 1000 * 0.5 * (at_rest + 4.6e-3) + 8000 * at_rest;
  CHECK(e.seconds() == doctest::Approx(time).epsilon(0.1));
  CHECK(e.bytes_at_rest() == 2100 * detail::bytes_per_contact);
}

TEST_CASE("a dry run without contacts supposes the time of a contact") {
  detail::run_estimate e = falling();
  for (int k = 0; k < 10; ++k) e.trial.push_back(part_of(10, 0, 0));
  CHECK(e.step_at_end() == doctest::Approx(1e-3));
  CHECK(e.step_at_rest() == doctest::Approx(1e-3 * (1 + 3 * detail::time_of_contact_over_body)));
  CHECK(e.seconds() == doctest::Approx(0.1 + 1900 * 0.5 * 17e-3 + 8000 * 16e-3));
}

TEST_CASE("a dry run whose contacts no longer grow keeps them, and without gravity all of them") {
  detail::run_estimate e = falling();
  for (int k = 0; k < 30; ++k) e.trial.push_back(part_of(100, 1000, k % 2 == 0 ? 1000 : 1020));
  CHECK(e.settled());
  CHECK(e.contacts_at_rest() == 1020);
  CHECK(e.seconds() == doctest::Approx(10000 * 5e-3).epsilon(0.01));
  e.steps_of_fall = 4000;  // the bodies at the top are not down yet
  CHECK_FALSE(e.settled());
  CHECK(e.contacts_at_rest() == 3000);
  e.first_step = 1500;  // a restart: they are
  CHECK(e.settled());
  detail::run_estimate gas = falling();
  gas.gravity = gas.falls = false;
  gas.trial.push_back(part_of(100, 20, 20));
  CHECK(gas.contacts_at_rest() == 20);
  CHECK(gas.seconds() == doctest::Approx(10000 * gas.step_at_end()));
}

TEST_CASE("a dry run of a run without steps takes no time") {
  detail::run_estimate e = falling();
  e.steps = 0;
  CHECK(e.contacts_at_rest() == 0);
  CHECK(e.step_at_rest() == 0);
  CHECK(e.seconds() == 0);
  const std::string text = detail::to_text(e, "grains");
  CHECK(text.find("there is no step to be made") != text.npos);
  CHECK(text.find("rest") == text.npos);
}

TEST_CASE("the contacts at rest of a dry run are those of the run within 1.5 times") {
  for (const int ranks : {1, 2, 4})
    for (const int layers : {1, 4})
      threads::launch({.ranks = ranks}, [&](threads::link& link) {
        CAPTURE(ranks);
        CAPTURE(layers);
        world<grains> w(link, columns_of_space{.lower = {-5, -5}, .upper = {5, 5}});
        fill_with_spheres(w, layers);
        const real dt = 1.0 / 240;
        // While they fall.
        const detail::run_estimate early = estimate_of_call(w, 60, dt);
        CHECK(early.bodies == 64);
        CHECK(early.movable == 64);
        CHECK(early.contacts() < 64);
        CHECK(early.trial_steps() == 59);
        w.simulate({.steps = 900, .dt = dt});
        // At rest: as after a restart.
        const detail::run_estimate late = estimate_of_call(w, 100, dt);
        CHECK(late.settled());
        CHECK(late.contacts() >= 64);
        CHECK(late.contacts_at_rest() == late.contacts());
        if (layers > 1) {
          CHECK(early.contacts_at_rest() < 1.5 * late.contacts_at_rest());
          CHECK(early.contacts_at_rest() > late.contacts_at_rest() / 1.5);
        }
        const std::string text = detail::to_text(late, "grains");
        CHECK(text.find("and their number no longer grows") != text.npos);
        CHECK(detail::to_text(early, "grains").find(" at rest; ") != text.npos);
      });
}
