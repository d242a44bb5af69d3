// The estimate of --dry-run: contacts at rest beside those of the run itself, on one, two and four
// ranks, and the time of runs whose steps have known times.
#include <doctest/doctest.h>

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

}  // namespace

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
        w.step(dt);
        // While they fall.
        const detail::run_estimate early = detail::estimate_run(w, 60);
        CHECK(early.bodies == 64);
        CHECK(early.movable == 64);
        CHECK(early.contacts() < 64);
        CHECK(early.trial_steps() == 59);
        for (int k = 0; k < 900; ++k) w.step(dt);
        // At rest: as after a restart.
        const detail::run_estimate late = detail::estimate_run(w, 100);
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
