// features<events> with soft laws that act beyond touch: bodies that pass within the range of the
// law have no events, and a contact lasts until its bond, its neck or its bridge is gone.
// timeout: 120
// alone
#include <doctest/doctest.h>

#include <array>
#include <cstdio>
#include <talus/adhesion.hpp>
#include <talus/checkpoint.hpp>
#include <talus/events.hpp>
#include <talus/liquid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/bonds.hpp>
#include <type_traits>
#include <utility>

using namespace talus;

namespace {

using domains = periodic<grid<dynamic>, along::x>;
template <class Law, class... More>
using scene =
    scenario<bodies<sphere>, Law, decomposition<domains>, features<events, checkpoints, More...>>;
using bonded = scene<soft_contact<linear_spring_dashpot, parallel_bond>>;
using sticky = scene<soft_contact<jkr_adhesion, coulomb_friction>>;
using wet = scene<soft_contact<linear_spring_dashpot, coulomb_friction, from_films<willett_bridge>>,
                  surface_liquid>;

template <class World>
void make_material(World& w) {
  using scenario_type = typename World::scenario_type;
  if constexpr (std::is_same_v<scenario_type, sticky>) {
    const auto m =
        w.material({.density = 1, .restitution = 0.6, .friction = 0.4, .youngs_modulus = 2e4});
    w.interaction(m, m, jkr_adhesion::given{.work_of_adhesion = 2});
  } else {
    const auto m =
        w.material({.density = 1, .restitution = 0.9, .friction = 0.4, .stiffness = 1e4});
    if constexpr (std::is_same_v<scenario_type, wet>)
      w.interaction(m, m,
                    willett_bridge::parameters{
                        .tension = 0.05, .angle = 0.2, .volume = 1e-2, .viscosity = 0.02});
    else
      w.interaction(m, m,
                    parallel_bond::parameters{.youngs_modulus = 1e4,
                                              .poisson_ratio = 0.2,
                                              .range = 0.2,
                                              .tensile_strength = 1e2,
                                              .shear_strength = 1e2});
  }
}

/// The number of events by kind, and the gap at the start of the step in which a contact begins.
struct encounter {
  std::array<int, 5> events{};
  double first = -1;
};
/// Two spheres of radius 0.5 at the side of a periodic box, the second one `from` the first and
/// with a velocity; those nearer than `bond` are bonded.
template <class Scenario>
[[nodiscard]] encounter meet(int ranks, const vec3& from, const vec3& v, bool restart = false,
                             double bond = 0) {
  encounter result;
  const real dt = 2e-4;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    const auto each = [&](auto&& program) {
      world<Scenario> w(link, domains{{.cells = {ranks}, .lower = {-3}, .upper = {3}}}, reach{1.4});
      make_material(w);
      w.template feature<events>().impacts({.speed = 0.1});
      program(w);
    };
    const auto follow = [&](auto& w, int begin, int end) {
      for (int k = begin; k < end; ++k) {
        w.step(dt);
        for (const event& e : all_events(w)) {
          if (w.rank() == 0) ++result.events[static_cast<std::size_t>(e.kind)];
          if (w.rank() == 0 && e.kind == event_kind::contact_begins)
            result.first = (from + (k * dt) * v).norm() - 1;
        }
      }
    };
    const int steps = 4000, half = 160;
    each([&](auto& w) {
      const vec3 at(2.9, 0, 0);
      w.add_if_local(body{.shape = sphere{0.5}, .position = at});
      vec3 other = at + from;
      if (other[0] > 3) other[0] -= 6;
      w.add_if_local(body{.shape = sphere{0.5}, .position = other, .velocity = v});
      if constexpr (std::is_same_v<Scenario, wet>)
        w.for_each_local([](auto&& b) { b.template set<liquid>(0.01 * b.shape().volume()); });
      if constexpr (std::is_same_v<Scenario, bonded>)
        if (w.synchronize(), bond > 0) CHECK(bond_within(w, bond) == 1);
      follow(w, 0, restart ? half : steps);
      if (restart) write_checkpoint(w, "events_reach.h5");
    });
    if (!restart) return;
    each([&](auto& w) {
      (void)read_checkpoint(w, "events_reach.h5");
      follow(w, half, steps);
    });
  });
  return result;
}

using numbers = std::array<int, 5>;

}  // namespace

TEST_CASE_TEMPLATE("bodies that pass within the range of a law have no events", Scenario, bonded,
                   sticky, wet) {
  for (const int ranks : {1, 2}) {
    const encounter e = meet<Scenario>(ranks, {-0.5, 1.02, 0}, {1.5, 0, 0});
    CHECK(e.events == numbers{});
  }
}

TEST_CASE_TEMPLATE("a contact begins at the touch and ends when nothing holds the bodies", Scenario,
                   bonded, sticky, wet) {
  for (const auto& [ranks, restart] : {std::pair{1, false}, {2, false}, {2, true}}) {
    const encounter e = meet<Scenario>(ranks, {1.03, 0, 0}, {-1.2, 0, 0}, restart);
    CHECK(e.events[0] == 1);
    CHECK(e.events[1] == 1);
    CHECK(e.events[2] == 1);
    CHECK(e.first == doctest::Approx(0).epsilon(0.001));
  }
  std::remove("events_reach.h5");
}

TEST_CASE("a bond without force is a contact, until it breaks") {
  for (const int ranks : {1, 2}) {
    for (const bool restart : {false, true}) {
      const encounter e = meet<bonded>(ranks, {1.01, 0, 0}, {0, 0, 0}, restart, 0.05);
      CHECK(e.events == numbers{1, 0, 0, 0, 0});
      const encounter f = meet<bonded>(ranks, {1.01, 0, 0}, {4, 0, 0}, restart, 0.05);
      CHECK(f.events == numbers{1, 1, 0, 0, 0});
    }
  }
  std::remove("events_reach.h5");
}
