// Laws of adhesion in a world: energy books, momentum, any ranks, sides of a periodic box, and
// restarts; parameters that make no sense.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <talus/adhesion.hpp>
#include <talus/checkpoint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/each_contact.hpp>

using namespace talus;

namespace {

using around = periodic<grid<dynamic, dynamic, dynamic>, along::x, along::y, along::z>;
const around sides{{.lower = {-2, -2, -2}, .upper = {2, 2, 2}}};
template <class... Parts>
using scene = scenario<bodies<sphere, box>, soft_contact<Parts...>, decomposition<around>,
                       features<energy_ledger, checkpoints>>;
using sticky = scene<jkr_adhesion, coulomb_friction, rolling_resistance, twisting_resistance>;

const material grain{.density = 1,
                     .restitution = 0.6,
                     .friction = 0.4,
                     .youngs_modulus = 2e4,
                     .rolling_friction = 0.05};

/// Bodies that fly about in a periodic box and stick.
template <class World>
void set_up_cloud(World& w) {
  const auto m = w.material(grain);
  w.interaction(m, m, jkr_adhesion::given{.work_of_adhesion = 2});
  w.interaction(m, m, twisting_resistance::parameters{.twisting_friction = 0.03});
  random_stream random(5, 1);
  for (int k = 0; k < 48; ++k) {
    const vec3 at(-1.5 + k % 4, -1.5 + k / 4 % 4, -1.2 + 1.2 * (k / 16));
    const vec3 v = vec3(1, 0.4, 0) + random.uniform(vec3(-3, -3, -3), vec3(3, 3, 3));
    if (k % 6 == 0)
      w.add_if_local(body{.shape = box{{0.6, 0.5, 0.7}},
                          .position = at,
                          .velocity = v,
                          .orientation = random.rotation()});
    else
      w.add_if_local(
          body{.shape = sphere{random.uniform(0.25, 0.45)}, .position = at, .velocity = v});
  }
}
/// The number of contacts that pull, summed over some steps.
template <class World>
double fly(World& w, int steps) {
  double pulls = 0;
  for (int k = 0; k < steps; ++k) {
    w.step(2e-4);
    if (k % 20 == 0)
      for_each_contact(w, [&](const loaded_contact& c) { pulls += c.force.dot(c.normal) < 0; });
  }
  w.link().reduce(reduction::sum, std::span<double>(&pulls, 1));
  return pulls;
}

}  // namespace

TEST_CASE("a sticky cloud keeps its momentum and its books, and moves alike on any ranks") {
  const std::string file = "adhesion_restart.h5";
  std::string digest;
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<sticky> w(link, sides);
      set_up_cloud(w);
      const vec3 before = measure_motion(w).momentum;
      double pulls = fly(w, 800);
      if (ranks == 2) write_checkpoint(w, file);
      pulls += fly(w, 800);
      const vec3 drift = measure_motion(w).momentum - before;
      const auto energy = measure_energy(w);
      const std::string now = state_digest(w);
      if (link.rank() != 0) return;
      CHECK(pulls > 100);
      CHECK(drift.norm() < 1e-12 * before.norm());
      CHECK(energy.worst < 1e-11);
      CHECK(energy.total.impact > 0);
      CHECK((digest.empty() || now == digest));
      digest = now;
    });
  }
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<sticky> w(link, sides);
      set_up_cloud(w);
      read_checkpoint(w, file);
      (void)fly(w, 800);
      const std::string now = state_digest(w);
      if (link.rank() == 0) CHECK(now == digest);
    });
  }
  std::remove(file.c_str());
}

TEST_CASE("a law that is given part of its parameters derives the others from the materials") {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<sticky> w(link, sides);
    const auto m = w.material(grain), wall = w.material({.youngs_modulus = rigid});
    CHECK_THROWS_WITH_AS((void)w.interaction<jkr_adhesion>(m, wall),
                         "jkr_adhesion has no parameters for the materials 0 and 1: give them to "
                         "world.interaction, as a value of jkr_adhesion::given",
                         std::runtime_error);
    w.interaction(wall, m, jkr_adhesion::given{.work_of_adhesion = 3});
    const auto p = w.interaction<jkr_adhesion>(m, wall);
    const material stiff{.youngs_modulus = rigid};
    CHECK(p.modulus == hertz_mindlin::combine(grain, stiff, {}).modulus);
    CHECK(p.work_of_adhesion == 3);
    w.material_pair(m, wall, {.restitution = 1});
    CHECK(w.interaction<jkr_adhesion>(m, wall).damping == 0);
  });
}

TEST_CASE("parameters of adhesion without meaning are refused") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    using every = scene<cohesive_spring, coulomb_friction, rolling_resistance, twisting_resistance,
                        dmt_adhesion, linear_cohesion, van_der_waals>;
    world<sticky> w(link, sides);
    const auto m = w.material(grain);
    CHECK_THROWS_WITH_AS(w.interaction(m, m, jkr_adhesion::given{-1}),
                         "jkr_adhesion has .work_of_adhesion = -1: give a finite number that is "
                         "not negative, of the dimension energy over area",
                         std::invalid_argument);
    CHECK_THROWS_WITH_AS(w.material({.density = 1}), doctest::Contains("needs a positive Young's"),
                         std::invalid_argument);
    CHECK_THROWS_WITH_AS(w.interaction(m, m, twisting_resistance::parameters{std::nan("")}),
                         doctest::Contains("twisting_resistance has .twisting_friction = nan"),
                         std::invalid_argument);
    world<every> v(link, sides);
    const auto n = v.material(grain);
    const auto refused = [&](const auto& p, const char* message) {
      CHECK_THROWS_WITH_AS(v.interaction(n, n, p), doctest::Contains(message),
                           std::invalid_argument);
    };
    refused(dmt_adhesion::parameters{-2}, "dmt_adhesion has .work_of_adhesion = -2");
    refused(linear_cohesion::parameters{-2}, "linear_cohesion has .energy_density = -2");
    refused(van_der_waals::parameters{.hamaker = 1, .least_distance = 0, .cutoff = 1},
            "give a least distance that is positive and below the cutoff");
    refused(cohesive_spring::parameters{.loading = 2, .unloading = 1},
            "cohesive_spring has .unloading = 1: give a finite stiffness that is at least that of "
            "loading");
    refused(rolling_resistance::parameters{-0.1},
            "rolling_resistance has .rolling_friction = -0.1");
  });
}
