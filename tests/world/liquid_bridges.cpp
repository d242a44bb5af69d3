// Liquid bridges of the library in a world: rupture, energy, momentum, and liquid that belongs to
// bodies, over ranks, sides of a periodic box, migration and restart.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>
#include <talus/checkpoint.hpp>
#include <talus/liquid.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <type_traits>
#include <utility>

using namespace talus;

namespace {

using domains = grid<dynamic, dynamic>;
const material grain{
    .density = 1, .restitution = 0.3, .friction = 0.4, .stiffness = 1e4, .rolling_friction = 0.05};
const willett_bridge::parameters water{
    .tension = 0.05, .angle = 0.2, .volume = 1e-2, .viscosity = 0.02};

// Fixed volumes.

template <class Bridge, class Integrator = semi_implicit_euler>
using pair_scene = scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, Bridge>,
                            integrator<Integrator>, decomposition<domains>,
                            features<energy_ledger, momentum_balance>>;

/// Two spheres that touch and part along x at this speed: the kinetic energy that they lose, the
/// last gap at which a force acts, and the largest error of the energy ledger.
template <class Bridge, class Integrator>
std::array<real, 3> pull_apart(const typename Bridge::parameters& p, int ranks) {
  const real speed = 2, r = 0.5, dt = 1e-4;
  const bool later = std::is_same_v<Integrator, velocity_verlet>;  // computes forces after a step
  const real overlap = (later ? 2 * speed * dt : 0) + 1e-9;
  std::array<real, 3> result{};
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<pair_scene<Bridge, Integrator>> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
    const auto m = w.material(grain);
    w.interaction(m, m, p);
    for (const int side : {-1, 1})
      w.add_if_local(body{.shape = sphere{r},
                          .position = {side * (r - 0.5 * overlap), 0, 0},
                          .velocity = {side * speed, 0, 0}});
    const real before = measure_motion(w).kinetic_energy;
    real end = 0;
    for (int k = 0; k < 1000; ++k) {
      w.step(dt);
      std::array<double, 2> sums{};  // gap, by the symmetry, and contacts
      w.for_each_local([&](const auto& b) { sums[0] += std::abs(b.position()[0]) - r; });
      for_each_contact(w, [&](const loaded_contact&) { sums[1] += 1; });
      link.reduce(reduction::sum, std::span<double>(sums));
      if (sums[1] > 0) end = sums[0];
    }
    const real after = measure_motion(w).kinetic_energy, closure = measure_energy(w).worst;
    if (link.rank() == 0) result = {before - after, end, closure};
  });
  return result;
}

template <class Bridge>
void check_rupture() {
  const typename Bridge::parameters p{.tension = 2, .angle = 0.2, .volume = 1e-2};
  const real rupture = 1.1 * std::cbrt(1e-2);
  const real work = -Bridge::stored({.gap = 0, .radius = 0.25}, p, {.volume = p.volume}).normal;
  for (const auto& [lost, end, closure] :
       {pull_apart<Bridge, semi_implicit_euler>(p, 1), pull_apart<Bridge, velocity_verlet>(p, 2)}) {
    CHECK(end == doctest::Approx(rupture).epsilon(3e-3));
    CHECK(lost == doctest::Approx(work).epsilon(5e-3));
    CHECK(closure < 1e-11);
  }
}

// Liquid that belongs to bodies.

using films = from_films<willett_bridge>;
template <class... Features>
using film_scene =
    scenario<bodies<sphere, box, plane>,
             soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance, films>,
             decomposition<domains>, features<surface_liquid, checkpoints, Features...>>;

/// Counts films that grew since the last call, from bridges that ruptured.
class growing_films {
 public:
  template <class World>
  [[nodiscard]] std::uint64_t count(World& w) {
    std::uint64_t grown = 0;
    std::map<system_id, real> now;
    w.for_each_local([&](const auto& b) {
      const real film = now[b.id()] = b.template get<liquid>();
      const auto before = last_.find(b.id());
      grown += before != last_.end() && film > before->second;
    });
    last_ = std::move(now);
    w.link().reduce(reduction::sum, std::span(&grown, 1));
    return grown;
  }

 private:
  std::map<system_id, real> last_;
};

template <class World>
void set_up_heap(World& w) {
  const auto m = w.material(grain);
  w.interaction(m, m, water);
  w.global([&](auto& s) {
    s.add(plane{}, m);
    for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
      s.add(plane{n, -3.2}, m);
  });
  random_stream random(11, 1);
  for (int k = 0; k < 60; ++k) {
    const vec3 at{-2.2 + 0.9 * (k % 6), -2.0 + 0.9 * (k / 6 % 5), 0.5 + 0.9 * (k / 30)};
    const vec3 v = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
    if (k % 6 == 0)
      w.add_if_local(body{.shape = box{{0.6, 0.5, 0.7}},
                          .position = at,
                          .velocity = v,
                          .orientation = random.rotation()});
    else
      w.add_if_local(
          body{.shape = sphere{random.uniform(0.25, 0.45)}, .position = at, .velocity = v});
  }
  w.for_each_local([](auto&& b) { b.template set<liquid>(0.02 * b.shape().volume()); });
}
/// Shakes the heap sideways, so that bridges form and rupture; returns the largest relative error
/// of the sum of liquid. `seen` has how many bridges there were at its checks, and how many films
/// had grown.
template <class World>
real shake(World& w, int first, int last, real initial, std::array<std::uint64_t, 2>& seen) {
  real worst = 0;
  growing_films films;
  for (int k = first; k < last; ++k) {
    const int phase = k / 150 % 4;
    w.gravity({phase == 0 ? 80.0 : phase == 2 ? -80.0 : 0, phase == 1 ? 60.0 : 0, -10});
    w.step(3e-4);
    if (k % 10 == 9) {
      const auto now = total_liquid(w);
      worst = std::max(worst, std::abs(now.total() / initial - 1));
      seen[0] += now.count, seen[1] += films.count(w);
    }
  }
  return worst;
}

}  // namespace

TEST_CASE(
    "bridges of the library rupture at their distance, and cost the work of their closed form") {
  check_rupture<willett_bridge>();
  check_rupture<rabinovich_bridge>();
}

TEST_CASE("a viscous bridge costs more than its rupture, and the books close") {
  const auto dry = pull_apart<willett_bridge, semi_implicit_euler>(
      {.tension = 0.05, .angle = 0.2, .volume = 1e-2}, 1);
  const auto viscous = pull_apart<willett_bridge, semi_implicit_euler>(water, 1);
  const auto over_ranks = pull_apart<willett_bridge, semi_implicit_euler>(water, 2);
  CHECK(viscous[0] > 1.01 * dry[0]);
  CHECK(over_ranks[0] == doctest::Approx(viscous[0]).epsilon(1e-12));
  CHECK(viscous[2] < 1e-11);
}

TEST_CASE("parameters of bridges without meaning are refused") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<pair_scene<willett_bridge>> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
    const auto m = w.material(grain);
    const auto refused = [&](auto change, const char* message) {
      auto p = water;
      change(p);
      CHECK_THROWS_WITH_AS(w.interaction(m, m, p), message, std::invalid_argument);
    };
    refused(
        [](auto& p) { p.angle = 90; },
        "a liquid bridge has .angle = 90: give a contact angle in radians from 0 to below pi/2");
    refused([](auto& p) { p.volume = -1; },
            "a liquid bridge has .volume = -1: give a finite number that is not negative");
    refused([](auto& p) { p.tension = std::nan(""); },
            "a liquid bridge has .tension = nan: give a finite number that is not negative");
  });
}

TEST_CASE("momentum is conserved with bridges, over ranks and the sides of a periodic box") {
  using around = periodic<grid<dynamic, dynamic, dynamic>, along::x, along::y, along::z>;
  using scene =
      scenario<bodies<sphere>, soft_contact<linear_spring_dashpot, coulomb_friction, films>,
               decomposition<around>, features<surface_liquid, energy_ledger>>;
  std::string digest;
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<scene> w(link, around{{.lower = {-2, -2, -2}, .upper = {2, 2, 2}}});
      const auto m = w.material(grain);
      w.interaction(m, m, water);
      random_stream random(5, 1);
      for (int k = 0; k < 48; ++k)
        w.add_if_local(
            body{.shape = sphere{random.uniform(0.25, 0.45)},
                 .position = vec3(-1.5 + k % 4, -1.5 + k / 4 % 4, -1.2 + 1.2 * (k / 16)),
                 .velocity = vec3(1, 0.4, 0) + random.uniform(vec3(-6, -6, -6), vec3(6, 6, 6))});
      w.for_each_local([](auto&& b) { b.template set<liquid>(0.02 * b.shape().volume()); });
      const vec3 before = measure_motion(w).momentum;
      const real poured = total_liquid(w).total();
      std::uint64_t bridges = 0, grown = 0;
      growing_films films;
      for (int k = 0; k < 1500; ++k) {
        w.step(2e-4);
        if (k % 50 == 49) {
          const auto now = total_liquid(w);
          bridges += now.count, grown += films.count(w);
          CHECK(std::abs(now.total() - poured) < 1e-14 * poured);
        }
      }
      const vec3 drift = measure_motion(w).momentum - before;
      const auto energy = measure_energy(w);
      const std::string now = state_digest(w);
      if (link.rank() != 0) return;
      CHECK(bridges > 100);
      CHECK(grown > 20);
      CHECK(drift.norm() < 1e-12 * before.norm());
      CHECK(energy.worst < 1e-11);
      CHECK(energy.total.impact > 0);
      CHECK((digest.empty() || now == digest));
      digest = now;
    });
  }
}

TEST_CASE("a wet cluster conserves momentum and angular momentum over ranks") {
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<film_scene<>> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
      const auto m = w.material(grain);
      auto sticky = water;
      sticky.tension = 1, sticky.viscosity = 0.2;
      w.interaction(m, m, sticky);
      random_stream random(8, 1);
      for (int k = 0; k < 27; ++k) {
        const vec3 at = vec3(0.3, -0.2, 0.1) + 0.79 * vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        w.add_if_local(body{.shape = sphere{random.uniform(0.37, 0.42)},
                            .position = at,
                            .velocity = vec3(2, 1, 0) + vec3(0, 0, 3).cross(at),
                            .angular_velocity = random.uniform(vec3(-9, -9, -9), vec3(9, 9, 9))});
      }
      w.for_each_local([](auto&& b) { b.template set<liquid>(0.02 * b.shape().volume()); });
      const motion before = measure_motion(w);
      for (int k = 0; k < 800; ++k) w.step(2e-4);
      const motion after = measure_motion(w);
      const auto liquids = total_liquid(w);
      if (link.rank() != 0) return;
      CHECK(liquids.count > 20);
      CHECK((after.momentum - before.momentum).norm() < 1e-12 * before.momentum.norm());
      CHECK((after.angular_momentum - before.angular_momentum).norm() <
            1e-12 * before.angular_momentum.norm());
      CHECK(after.kinetic_energy < 0.99 * before.kinetic_energy);
    });
  }
}

TEST_CASE("a shaken wet heap loses no liquid, and moves alike on any ranks and after a restart") {
  using scene = film_scene<energy_ledger>;
  const std::string file = "liquid_bridges_restart.h5";
  const int half = 400, all = 1200;
  std::string digest;
  std::array<std::uint64_t, 2> bridges{};
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<scene> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
      set_up_heap(w);
      const real poured = total_liquid(w).total();
      std::array<std::uint64_t, 2> seen{};
      real worst = shake(w, 0, half, poured, seen);
      if (ranks == 2) write_checkpoint(w, file);
      worst = std::max(worst, shake(w, half, all, poured, seen));
      const std::string now = state_digest(w);
      const auto end = total_liquid(w);
      // Per body by its column, per bridge by for_each_bridge.
      std::array<double, 2> sums{};
      w.for_each_local([&](const auto& b) { sums[0] += b.template get<liquid>(); });
      for_each_bridge(w, [&](const liquid_bridge_of& b) { sums[1] += b.volume; });
      link.reduce(reduction::sum, std::span<double>(sums));
      const real closure = measure_energy(w).worst;
      if (link.rank() != 0) return;
      CHECK(poured > 0);
      CHECK(worst < 1e-14);
      CHECK(closure < 1e-11);
      CHECK(end.bridges > 0.05 * poured);
      CHECK(end.films > 0.01 * poured);
      CHECK(sums[0] == doctest::Approx(end.films).epsilon(1e-13));
      CHECK(sums[1] == doctest::Approx(end.bridges).epsilon(1e-13));
      CHECK((digest.empty() || now == digest));
      CHECK(seen[0] > 500);
      CHECK(seen[1] > 20);
      CHECK((bridges[0] == 0 || seen[0] == bridges[0]));
      digest = now, bridges = seen;
    });
  }
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<scene> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
      set_up_heap(w);
      const real poured = total_liquid(w).total();
      read_checkpoint(w, file);
      std::array<std::uint64_t, 2> seen{};
      const real worst = shake(w, half, all, poured, seen);
      const std::string now = state_digest(w);
      if (link.rank() != 0) return;
      CHECK(now == digest);
      CHECK(worst < 1e-14);
    });
  }
  std::remove(file.c_str());
}

TEST_CASE("bridges take from the films, and give back at their rupture and when bodies fly apart") {
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<film_scene<>> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
      const auto m = w.material(grain);
      auto p = water;
      p.tension = 0, p.viscosity = 0;
      w.interaction(m, m, p);
      const auto place = [&](real x, real film, std::uint64_t) {
        w.add_if_local(body{.shape = sphere{0.5}, .position = {x, 0.25, 0}});
        w.for_each_local([&](auto&& b) {
          if (b.position()[0] == x) b.template set<liquid>(film);
        });
      };
      // One that touches two others, one of which is dry.
      place(-0.9999, 0, 0), place(0, 4e-3, 1), place(0.9999, 1e-3, 2);
      const auto look = [&] {
        std::array<double, 3> films{};
        w.for_each_local([&](const auto& b) {
          films[static_cast<std::size_t>(std::lround(std::clamp(b.position()[0], -1.0, 1.0)) + 1)] =
              b.template get<liquid>();
        });
        link.reduce(reduction::sum, std::span<double>(films));
        return films;
      };
      const auto move = [&](real by) {
        w.for_each_local([&](auto&& b) {
          if (b.position()[0] > 0.5) b.translate({by, 0, 0}), b.set_velocity({0, 0, 0});
          if (b.position()[0] < -0.5) b.translate({-by, 0, 0}), b.set_velocity({0, 0, 0});
        });
        w.synchronize();
      };
      w.step(1e-6);
      CHECK(total_liquid(w).count == 0);
      w.step(1e-6);
      CHECK(total_liquid(w).count == 2);
      auto films = look();
      CHECK(films[0] == 0);
      CHECK(films[1] == 0);
      CHECK(films[2] == 0);
      CHECK(total_liquid(w).bridges == doctest::Approx(5e-3).epsilon(1e-14));
      // Within the range of the law, beyond the distance of the smaller bridge: 2e-3 on the left.
      const real left = 1.1 * std::cbrt(2e-3), right = 1.1 * std::cbrt(3e-3);
      move(0.5 * (left + right));
      w.step(1e-6);
      films = look();
      CHECK(total_liquid(w).count == 1);
      CHECK(films[0] == doctest::Approx(1e-3).epsilon(1e-14));
      CHECK(films[1] == doctest::Approx(1e-3).epsilon(1e-14));
      CHECK(films[2] == 0);
      // Far away in one step.
      move(1.7);
      w.step(1e-6);
      films = look();
      CHECK(total_liquid(w).count == 0);
      CHECK(films[1] == doctest::Approx(2.5e-3).epsilon(1e-14));
      CHECK(films[2] == doctest::Approx(1.5e-3).epsilon(1e-14));
      CHECK(total_liquid(w).total() == doctest::Approx(5e-3).epsilon(1e-14));
    });
  }
}

TEST_CASE("walls give no liquid and get none, and no bridge takes more than its volume") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<film_scene<>> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
    const auto m = w.material(grain);
    w.interaction(m, m, water);
    w.global([&](auto& s) {
      s.add(plane{}, m);
      s.add(box{{1, 1, 1}}, m, vec3(2, 0, 0.5));
    });
    const auto h = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0.4999}});
    const auto k = w.add(body{.shape = sphere{0.5}, .position = {2, 0, 1.4999}});
    w[h].template set<liquid>(4e-3), w[k].template set<liquid>(3e-2);
    for (int n = 0; n < 2; ++n) w.step(1e-6);
    CHECK(w[h].template get<liquid>() == 0);
    CHECK(w[k].template get<liquid>() == doctest::Approx(2e-2).epsilon(1e-14));
    CHECK(total_liquid(w).count == 2);
    CHECK(total_liquid(w).bridges == doctest::Approx(1.4e-2).epsilon(1e-14));
    w[h].translate({0, 0, 1}), w[k].translate({0, 0, 1});
    w.step(1e-6);
    CHECK(w[h].template get<liquid>() == doctest::Approx(4e-3).epsilon(1e-14));
    CHECK(w[k].template get<liquid>() == doctest::Approx(3e-2).epsilon(1e-14));
  });
}

TEST_CASE("films and shares without meaning are refused where bodies touch") {
  const auto touch = [](real film, real fraction) {
    threads::launch({.ranks = 1}, [&](threads::link& link) {
      world<film_scene<>> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
      const auto m = w.material(grain);
      w.interaction(m, m, water);
      w.feature<surface_liquid>().fraction = fraction;
      for (const real x : {-0.4999, 0.4999})
        w.add_if_local(body{.shape = sphere{0.5}, .position = {x, 0.25, 0}});
      w.for_each_local([&](auto&& b) { b.template set<liquid>(film); });
      w.step(1e-6);
    });
  };
  touch(1e-3, 0.05);
  CHECK_THROWS_WITH_AS(touch(-1e-3, 1), doctest::Contains("has the volume -0.001: set a finite"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(touch(std::nan(""), 1), doctest::Contains("has the volume nan: set a"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(touch(1e-3, 2), doctest::Contains("surface_liquid has .fraction = 2: set"),
                       std::runtime_error);
}
