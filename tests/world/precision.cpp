// Contacts solved in float: the laws of double hold to the round-off of floats, and bodies without
// contacts move as in double.
// long
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/observe/residual.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

constexpr real g = 9.81, dt = 1.0 / 240;

template <class Precision, class... Policies>
using balls = scenario<bodies<sphere, plane>, precision<Precision>, Policies...>;
template <class Precision>
using lone_balls = balls<Precision, transport<serial>>;
template <class Precision>
using shared_balls = balls<Precision, decomposition<grid<dynamic, dynamic>>,
                           features<momentum_balance, energy_ledger>>;
using mixed_bodies = scenario<bodies<sphere, box, plane>, precision<mixed_precision>,
                              decomposition<grid<dynamic, dynamic>>, features<momentum_balance>>;

constexpr real side = 4.5;

/// Spheres (and boxes) in a box of planes, or a cloud of them that falls together.
template <class World>
void set_up(World& w, bool cloud) {
  const auto stuff = w.material({.restitution = 0.3, .friction = 0.4});
  w.seed(5);
  if (!cloud) {
    w.gravity({0, 0, -g});
    w.global([&](auto& scope) {
      scope.add(plane{.normal = {0, 0, 1}}, stuff);
      for (const vec3& n : {vec3(1, 0, 0), vec3(0, 1, 0)}) {
        scope.add(plane{.normal = n}, stuff);
        scope.add(plane{.normal = -n, .offset = -side}, stuff);
      }
    });
  }
  const vec3 centre{side / 2, side / 2, 1.8};
  constexpr bool boxes = World::scenario_type::template has_shape<box>;
  w.fill(simple_cubic{.spacing = 0.9, .origin = {0.46, 0.46, 0.45}} &
             box_region{{0, 0, 0}, {side, side, 3.6}},
         [&](const site& at, random_stream& random) {
           vec3 push = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
           if (cloud) push += 2.0 * (centre - at.position);
           const body ball{.shape = sphere{random.uniform(0.4, 0.44)},
                           .position = at.position,
                           .velocity = push};
           if constexpr (boxes)
             return at.index % 5 == 0
                        ? std::variant<body<sphere>, body<box>>(body{.shape = box{{0.7, 0.6, 0.5}},
                                                                     .position = at.position,
                                                                     .velocity = push})
                        : std::variant<body<sphere>, body<box>>(ball);
           else
             return ball;
         });
  w.synchronize();
}

/// Makes `steps` steps on threads, then calls f(world, whether this is the reporting rank).
template <class Scenario, class F>
void on(int ranks, int steps, bool cloud, F&& f) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, {.lower = {0, 0}, .upper = {side, side}});
    set_up(w, cloud);
    for (int k = 0; k < steps; ++k) w.step(dt);
    f(w, link.rank() == 0);
  });
}

}  // namespace

TEST_CASE("velocities and contacts of spheres take half the bytes") {
  using namespace talus::detail;
  using law = hard_contact<coulomb_friction, newton_restitution>;
  using in_double = isotropic_contact<law, partner::moving>;
  using in_float = isotropic_contact<law, partner::moving, float>;
  CHECK(sizeof(solver_body_of<float>) == 32);
  CHECK(2 * sizeof(solver_body_of<float>) == sizeof(solver_body));
  CHECK(2 * sizeof(body_shift_of<float>) == sizeof(body_shift));
  const auto per_contact = []<class Contact>(const Contact&) {
    return (sizeof(isotropic_block<Contact>) +
            sizeof(isotropic_correction<wide_pack<typename Contact::number>>)) /
           static_cast<std::size_t>(lanes_of<wide_pack<typename Contact::number>>);
  };
  CHECK(per_contact(in_double{}) == 128);
  CHECK(per_contact(in_float{}) == 68);  // 8 of them are the two bodies' indices
}

TEST_CASE("what touches nothing moves as in double, to the bit") {
  const auto flown = []<class Precision>(Precision) {
    serial::link link;
    world<lone_balls<Precision>> w(link);
    w.material({});
    w.gravity({0, 0, -g});
    for (int k = 0; k < 20; ++k)
      w.add(body{.shape = sphere{0.3},
                 .position = {1.1 * k, 1e4 / 3, 7.7},
                 .velocity = {0.1 * k, 100.0 / 3, 1e-7 * k},
                 .angular_velocity = {1.0 / 7, 0, 0}});
    for (int k = 0; k < 100; ++k) w.step(dt);
    return state_digest(w);
  };
  CHECK(flown(double{}) == flown(mixed_precision{}));
}

TEST_CASE("two spheres collide as the closed form says, to the round-off of floats") {
  serial::link link;
  world<lone_balls<mixed_precision>> w(link);
  w.material({.restitution = 0.7, .friction = 0});
  const auto a = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0}, .velocity = {3, 1, 0}});
  const auto b = w.add(body{.shape = sphere{0.8}, .position = {1.6, 0, 0}, .velocity = {-1, 0, 0}});
  const real ma = w[a].mass(), mb = w[b].mass();
  for (int k = 0; k < 60; ++k) w.step(dt);
  // The contact points follow from the gaps, which are doubles.
  const vec3 n = (w[a].velocity() - vec3(3, 1, 0)).normalized();
  const real before = n.dot(vec3(4, 1, 0));
  CHECK(before < -3);
  const real p = -(1 + 0.7) * before / (1 / ma + 1 / mb);
  CHECK((w[a].velocity() - vec3(3, 1, 0) - (p / ma) * n).norm() < 1e-6);
  CHECK((w[b].velocity() - vec3(-1, 0, 0) + (p / mb) * n).norm() < 1e-6);
  const vec3 momentum = ma * w[a].velocity() + mb * w[b].velocity();
  CHECK((momentum - vec3(3 * ma - mb, ma, 0)).norm() < 1e-6 * 3 * ma);
}

TEST_CASE("a ball at rest rests, and one that slides stops where the closed form says") {
  serial::link link;
  world<lone_balls<mixed_precision>> w(link);
  w.material({.friction = 0.5});
  w.gravity({0, 0, -g});
  w.global([&](auto& s) { s.add(plane{}, {}); });
  const auto still = w.add(body{.shape = sphere{0.5}, .position = {-9, 0, 0.5}});
  // A ball that starts to slide rolls from v = 5/7 of its speed on, after 2 v / (7 mu g).
  const auto ball =
      w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0.5}, .velocity = {7, 0, 0}});
  for (int k = 0; k < 240; ++k) w.step(dt);
  CHECK(w[still].velocity().norm() < 1e-8);
  CHECK(std::abs(w[still].position()[2] - 0.5) < 1e-8);
  CHECK(w[ball].velocity()[0] == doctest::Approx(5).epsilon(1e-5));
  CHECK(w[ball].angular_velocity()[1] == doctest::Approx(10).epsilon(1e-5));
}

TEST_CASE("impulses lie in their cones and the residual falls to the round-off of floats") {
  for (const int ranks : {1, 4})
    on<shared_balls<mixed_precision>>(ranks, 90, false, [&](auto& w, bool speaks) {
      real before = 1;
      for (const int n : {3, 30, 300, 3000}) {
        w.solver().iterations = n;
        w.step(dt);
        const contact_residual r = measure_residual(w);
        if (speaks) {
          MESSAGE(ranks, " rank(s), ", n, " iterations: residual ", r.value, ", ", r.contacts,
                  " contacts");
          CHECK(r.contacts > 150);
          CHECK(r.value < std::max(0.3 * before, 2e-3));
          before = r.value;
        }
        bool in_cones = true;
        talus::detail::state_of(w).each_contact_list([&](const auto& list) {
          list.each([&](const auto& c, bool) {
            in_cones = in_cones && c.rn >= 0 && c.rt.norm() <= c.friction * c.rn * (1 + 1e-6f);
          });
        });
        CHECK(in_cones);
      }
      if (speaks) CHECK(before < 1e-5);
    });
}

TEST_CASE("with a tolerance all ranks stop after the same iteration") {
  on<shared_balls<mixed_precision>>(4, 90, false, [&](auto& w, bool) {
    w.solver().max_iterations = 20000;
    for (const real tolerance : {1e-2, 1e-4}) {
      w.solver().tolerance = tolerance;
      const std::uint64_t before = w.convergence().iterations;
      w.step(dt);
      std::uint64_t least = w.convergence().iterations - before, most = least;
      w.link().reduce(reduction::min, std::span(&least, 1));
      w.link().reduce(reduction::max, std::span(&most, 1));
      CHECK(least == most);
      CHECK(w.convergence().residual <= tolerance);
    }
  });
}

TEST_CASE_TEMPLATE("momentum is kept to the round-off of floats, on 1, 2 and 4 ranks", Scenario,
                   shared_balls<mixed_precision>, mixed_bodies) {
  for (const int ranks : {1, 2, 4})
    for (const bool cloud : {true, false})
      on<Scenario>(ranks, 1, cloud, [&](auto& w, bool speaks) {
        real worst = 0;
        for (int k = 0; k < 80; ++k) {
          w.step(dt);
          const momentum_account m = measure_momentum(w);
          worst = std::max(worst, m.closure().norm() / (m.size + m.gravity.norm()));
        }
        if (!speaks) return;
        MESSAGE(ranks, " rank(s): ", worst, " of the sum of absolute momenta in a step");
        CHECK(worst < 2e-7);
      });
}

TEST_CASE("a heap comes to rest, on 1 and 4 ranks, and the books of energy close") {
  for (const int ranks : {1, 4})
    on<shared_balls<mixed_precision>>(ranks, 1920, false, [&](auto& w, bool speaks) {
      const auto m = measure_motion(w);
      const auto p = measure_penetration(w);
      const auto e = measure_energy(w);
      const auto r = measure_residual(w);
      const auto balance = measure_momentum(w);
      if (!speaks) return;
      MESSAGE(ranks, " rank(s): kinetic energy ", m.kinetic_energy / m.mass, " J/kg, mean overlap ",
              p.mean, ", residual ", r.value, ", books ", e.error());
      CHECK(m.kinetic_energy / m.mass < 1e-4);  // a ball or two may still roll on the floor
      CHECK(p.mean < 1e-5);
      CHECK(p.max < 1e-3);
      CHECK(r.value < 1e-5);
      CHECK(e.error() < 1e-9);
      CHECK(balance.borne_weight() == doctest::Approx(1).epsilon(1e-4));
    });
}

TEST_CASE("a heavy ball on light ones is solved as one problem, on 1 and 4 ranks") {
  for (const int ranks : {1, 4})
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<shared_balls<mixed_precision>> w(link, {.lower = {-2, -2}, .upper = {2, 2}});
      const auto light = w.material({.density = 1, .friction = 0.5});
      const auto heavy = w.material({.density = 1000, .friction = 0.5});
      w.gravity({0, 0, -g});
      w.global([&](auto& scope) {
        scope.add(plane{}, light);
        for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
          scope.add(plane{.normal = n, .offset = -0.5}, light);
      });
      for (int k = 0; k < 10; ++k)
        w.add_if_local(body{
            .shape = sphere{0.5}, .position = {0, 0, k + 0.5}, .material = k == 9 ? heavy : light});
      real worst = 0;
      for (int k = 0; k < 240; ++k) {
        w.step(dt);
        worst = std::max(worst, measure_penetration(w).max);
      }
      if (link.rank() == 0) {
        MESSAGE(ranks, " rank(s): largest overlap ", worst);
        CHECK(worst < 1e-3);
      }
    });
}

TEST_CASE("boxes, forces, torques, damping and bodies followed on their way take floats too") {
  struct outcome {
    vec3 box_velocity, box_spin, ball_velocity;
    real ball_height = 0;
  };
  const auto after = []<class Precision>(Precision) {
    using all = scenario<bodies<sphere, box, plane>, precision<Precision>, transport<serial>,
                         features<forces, damping, continuous_collision, energy_ledger>>;
    serial::link link;
    world<all> w(link);
    w.material({.restitution = 0.5, .friction = 0});
    w.damping(0.9);
    w.global([&](auto& s) { s.add(plane{}, {}); });
    const auto free = w.add(body{.shape = box{{1, 2, 3}}, .position = {0, 0, 50}});
    const auto fast =
        w.add(body{.shape = sphere{0.1}, .position = {9, 0, 5}, .velocity = {0, 0, -500}});
    for (int k = 0; k < 20; ++k) {
      w[free].add_force({1, 2, 3});
      w[free].add_torque({3, 2, 1});
      w.step(dt);
    }
    return outcome{w[free].velocity(), w[free].angular_velocity(), w[fast].velocity(),
                   w[fast].position()[2]};
  };
  const outcome x = after(double{}), y = after(mixed_precision{});
  CHECK(x.box_velocity == y.box_velocity);  // it touches nothing
  CHECK(x.box_spin == y.box_spin);
  CHECK(x.ball_velocity[2] > 200);
  CHECK((x.ball_velocity - y.ball_velocity).norm() < 1e-6 * 250);
  CHECK(y.ball_height == doctest::Approx(x.ball_height).epsilon(1e-5));
}

TEST_CASE("masses that floats cannot work with are refused") {
  serial::link link;
  world<lone_balls<mixed_precision>> w(link);
  w.material({});
  CHECK_THROWS_WITH_AS(w.add(body{.shape = sphere{1e-7}}),
                       doctest::Contains("take masses between 1e-12 and 1e12"),
                       std::invalid_argument);
  w.add(body{.shape = sphere{1e-7}, .fixed = true});
}
