// The laws of every contact solver. The residual measures the quality of a solution.
#include <doctest/doctest.h>

#include <map>
#include <mutex>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/residual.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/solver/accelerated_jacobi.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/substepping.hpp>
#include <talus/world/world.hpp>

#include "../scenes/jacobi.hpp"
#include "../scenes/reproduced.hpp"
#include "../scenes/solids.hpp"

using namespace talus;

namespace {

constexpr real g = 9.81, dt = 1.0 / 240;

/// A heap of spheres and boxes in a box of planes, divided into columns; or, without gravity and
/// walls, a cloud that falls together.
template <class Scenario>
struct heap {
  using world_type = world<Scenario>;
  static constexpr real side = 4.5;
  static constexpr bool divides = detail::uses_substeps<typename Scenario::solver>;
  enum class kind { heap, cloud };

  static void set_up(world_type& w, kind what) {
    const auto stuff = w.material({.restitution = 0.3, .friction = 0.4});
    w.seed(5);
    if (what == kind::heap) {
      w.gravity({0, 0, -g});
      w.global([&](auto& scope) {
        scope.add(plane{.normal = {0, 0, 1}}, stuff);
        scope.add(plane{.normal = {1, 0, 0}}, stuff);
        scope.add(plane{.normal = {-1, 0, 0}, .offset = -side}, stuff);
        scope.add(plane{.normal = {0, 1, 0}}, stuff);
        scope.add(plane{.normal = {0, -1, 0}, .offset = -side}, stuff);
      });
    }
    const vec3 centre{side / 2, side / 2, 1.8};
    w.fill(
        simple_cubic{.spacing = 0.9, .origin = {0.46, 0.46, 0.45}} &
            box_region{{0, 0, 0}, {side, side, 3.6}},
        [&](const site& at, random_stream& random) -> std::variant<body<sphere>, body<box>> {
          vec3 push = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
          if (what == kind::cloud) push += 2.0 * (centre - at.position);
          if (random.uniform(0, 1) < 0.2)
            return body{.shape = box{{0.7, 0.6, 0.5}}, .position = at.position, .velocity = push};
          return body{.shape = sphere{random.uniform(0.4, 0.44)},
                      .position = at.position,
                      .velocity = push};
        });
    w.synchronize();
  }
  /// Makes `steps` steps, then calls f(world, whether this is the reporting rank).
  template <class F>
  static void on(int ranks, int steps, F&& f, kind what = kind::heap) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world_type w(link, grid<dynamic, dynamic>{.lower = {0, 0}, .upper = {side, side}});
      set_up(w, what);
      for (int k = 0; k < steps; ++k) w.step(dt);
      f(w, link.rank() == 0);
    });
  }
};

/// With substeps the books include those of the substeps.
using divided =
    heap<scenario<bodies<sphere, box, plane>, solver<substepping>, decomposition<any_decomposition>,
                  transport<threads>, features<energy_ledger, momentum_balance>>>;

template <class World>
std::string solver_name(const World&) {
  return World::scenario_type::solver::name;
}

template <class World>
std::uint64_t iterations_of_step(World& w) {
  const auto before = w.convergence().iterations;
  w.step(dt);
  return w.convergence().iterations - before;
}

}  // namespace

TEST_CASE_TEMPLATE("the residual falls with the iterations, on 1 and 4 ranks", Heap,
                   heap<scenes::solids>, heap<scenes::jacobi>, heap<scenes::reproduced>) {
  for (const int ranks : {1, 4})
    Heap::on(ranks, 90, [&](auto& w, bool speaks) {
      real before = 1;
      for (const int n : {3, 30, 300, 3000}) {
        w.solver().iterations = n;
        w.step(dt);
        const contact_residual r = measure_residual(w);
        if (!speaks) continue;
        MESSAGE(solver_name(w), ", ", ranks, " rank(s), ", n, " iterations: residual ", r.value,
                ", worst contact ", r.max, ", ", r.contacts, " contacts");
        CHECK(r.contacts > 150);
        CHECK(r.max >= r.value);
        // Each step is another problem; some are harder than the one before.
        CHECK(r.value < std::max(0.3 * before, 2e-3));
        before = r.value;
      }
      if (speaks) CHECK(before < 1e-5);
    });
}

TEST_CASE_TEMPLATE(
    "with a tolerance all ranks stop after the same iteration, where the residual is within it",
    Heap, heap<scenes::solids>, heap<scenes::jacobi>, heap<scenes::reproduced>, divided) {
  for (const int ranks : {1, 4})
    Heap::on(ranks, 90, [&](auto& w, bool speaks) {
      w.solver().max_iterations = 20000;
      for (const real tolerance : {1e-2, 1e-4, 1e-7}) {
        w.solver().tolerance = tolerance;
        const std::uint64_t needed = iterations_of_step(w);
        const double told = w.convergence().residual;
        const contact_residual r = measure_residual(w);
        std::uint64_t least = needed, most = needed;
        w.link().reduce(reduction::min, std::span(&least, 1));
        w.link().reduce(reduction::max, std::span(&most, 1));
        if (!speaks) continue;
        CHECK(needed > 1);
        MESSAGE(solver_name(w), ", ", ranks, " rank(s), tolerance ", tolerance, ": ", needed,
                " iterations, residual ", told, " told and ", r.value, " measured");
        CHECK(least == most);
        CHECK(told <= tolerance);
        if (!Heap::divides) CHECK(r.value == doctest::Approx(told).epsilon(1e-6));
      }
      w.solver().max_iterations = 5;  // too few, and reported as such
      const std::uint64_t above = w.convergence().steps_above;
      const int parts = Heap::divides ? w.solver().iterations : 1;
      CHECK(iterations_of_step(w) == static_cast<std::uint64_t>(5 * parts));
      const double told = w.convergence().residual;
      const contact_residual r = measure_residual(w);
      if (!speaks) return;
      CHECK(w.convergence().steps_above == above + 1);
      CHECK(told > 1e-7);
      // Impulses that would add energy have been scaled since.
      if (!Heap::divides) CHECK(std::abs(r.value - told) < 0.5 * told);
    });
}

TEST_CASE_TEMPLATE(
    "runs on the same ranks end with the same bits, whether the residual is measured or not, and "
    "steps without a tolerance are not collective",
    Heap, heap<scenes::solids>, heap<scenes::jacobi>, heap<scenes::reproduced>, divided) {
  for (const int ranks : {1, 4}) {
    std::vector<std::string> digests;
    for (const bool measured : {false, true})
      Heap::on(ranks, 60, [&](auto& w, bool speaks) {
        CHECK(w.step_messages().collectives == 0);
        for (int k = 0; k < 30; ++k) {
          w.step(dt);
          if (measured) (void)measure_residual(w);
        }
        CHECK(w.step_messages().collectives == 0);
        const auto digest = state_digest(w);
        if (speaks) digests.push_back(digest);
      });
    CHECK(digests[0] == digests[1]);
  }
}

TEST_CASE_TEMPLATE("impulses lie in their cones, on 1 and 4 ranks", Heap, heap<scenes::solids>,
                   heap<scenes::jacobi>, heap<scenes::reproduced>, divided) {
  for (const int ranks : {1, 4})
    Heap::on(ranks, 40, [&](auto& w, bool) {
      real outside = 0, pull = 0, largest = 0;
      for (int k = 0; k < 20; ++k) {
        w.solver().iterations = 1 + k;
        w.step(dt);
        detail::each_counted(talus::detail::state_of(w).contacts, [&](const auto& c) {
          const vec3 r = c.impulse();
          const real n = c.axis().dot(r);
          largest = std::max(largest, r.norm());
          pull = std::max(pull, -n);
          outside = std::max(outside, (r - n * c.axis()).norm() - c.mu() * n);
        });
      }
      CHECK(pull <= 0);
      CHECK(outside <= 1e-14 * largest);
    });
}

TEST_CASE_TEMPLATE("momentum is conserved to round-off, on 1 and 4 ranks", Heap,
                   heap<scenes::solids>, heap<scenes::jacobi>, heap<scenes::reproduced>, divided) {
  for (const int ranks : {1, 4})
    Heap::on(
        ranks, 0,
        [&](auto& w, bool speaks) {
          const motion before = measure_motion(w);
          for (int k = 0; k < 120; ++k) w.step(dt);
          const motion after = measure_motion(w);
          const real scale = std::sqrt(2 * before.mass * before.kinetic_energy);
          if (!speaks) return;
          CHECK(after.kinetic_energy < 0.7 * before.kinetic_energy);  // they have met
          CHECK((after.momentum - before.momentum).norm() < 1e-13 * scale);
        },
        Heap::kind::cloud);
}

TEST_CASE("a solver finds what Gauss-Seidel finds, if both iterate long enough") {
  const auto end_of = [](auto chosen, int ranks) {
    std::map<system_id, vec3> velocities;
    using chosen_heap = decltype(chosen);
    std::mutex mutex;
    chosen_heap::on(ranks, 0, [&](auto& w, bool) {
      w.solver().tolerance = 1e-11;
      w.solver().max_iterations = 100000;
      w.solver().correction = 0;
      for (int k = 0; k < 12; ++k) w.step(dt);
      CHECK(w.convergence().steps_above == 0);
      const std::lock_guard lock(mutex);
      w.for_each_local([&](const auto& b) { velocities[b.id()] = b.velocity(); });
    });
    return velocities;
  };
  for (const int ranks : {1, 4}) {
    const auto sought = end_of(heap<scenes::solids>{}, 1);
    for (const auto& found :
         {end_of(heap<scenes::jacobi>{}, ranks), end_of(heap<scenes::reproduced>{}, ranks)}) {
      REQUIRE(found.size() == sought.size());
      real largest = 0;
      for (const auto& [id, v] : sought) largest = std::max(largest, (found.at(id) - v).norm());
      MESSAGE(ranks, " rank(s): velocities within ", largest);
      CHECK(largest < 1e-7);
    }
  }
}

TEST_CASE("the books of a divided step close") {
  for (const int ranks : {1, 4})
    divided::on(ranks, 0, [&](auto& w, bool speaks) {
      w.solver().iterations = 7;
      for (int k = 0; k < 120; ++k) w.step(dt);
      const energy_balance e = measure_energy(w);
      const momentum_account m = measure_momentum(w);
      if (!speaks) return;
      CHECK(e.worst < 1e-12);
      CHECK(m.error() < 1e-11);
      CHECK(e.total.friction > 0);
    });
}

namespace {

/// A box that falls on a floor, at the corner of the domains, in steps of 1/60. Calls f(world)
/// before the first step and after each.
template <class F>
void drop(int ranks, const vec3& size, const vec3& spin, real restitution, int parts, F&& f) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    typename divided::world_type w(link,
                                   grid<dynamic, dynamic>{.lower = {-2, -2}, .upper = {2, 2}});
    const auto stuff = w.material({.restitution = restitution, .friction = 0.5});
    w.solver().iterations = parts;
    w.gravity({0, 0, -g});
    w.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, 1}}, stuff); });
    w.add_if_local(body{.shape = box{size},
                        .position = {-0.01, 0.01, 2},
                        .material = stuff,
                        .angular_velocity = spin});
    w.synchronize();
    f(w);
    for (int k = 0; k < 120; ++k) w.step(1.0 / 60), f(w);
  });
}

}  // namespace

TEST_CASE("where the step is divided, a thin box that spins gains no energy from a floor") {
  for (const int ranks : {1, 4})
    for (const real speed : {10., 30., 100., 300.})
      for (const vec3& axis : {vec3(0, 1, 0), vec3(0, 0, 1), vec3(0.6, 0.64, 0.48)}) {
        CAPTURE(ranks);
        CAPTURE(speed);
        CAPTURE(axis[2]);
        real initial = 0, highest = 0, last = 0, closure = 0;
        drop(ranks, {2, 0.05, 0.03}, speed * axis, 0.5, 10, [&](auto& w) {
          const motion m = measure_motion(w);
          const energy_balance e = measure_energy(w);
          if (w.rank() != 0) return;
          last = initial == 0 ? m.kinetic_energy + m.mass * g * 2 : e.kinetic + e.potential;
          if (initial == 0) initial = last;
          highest = std::max(highest, last);
          closure = std::max(closure, e.worst);
        });
        CHECK(highest < 1.001 * initial);
        CHECK(last < 0.9 * initial);  // it has struck the floor
        CHECK(closure < 1e-11);
      }
}

TEST_CASE("where the step is divided, a cube that falls flat rebounds flat, to e^2 of its height") {
  for (const int parts : {5, 10, 50})
    for (const real e : {0.0, 0.5, 0.8}) {
      CAPTURE(parts);
      CAPTURE(e);
      real top = 0, turn = 0, lowest = 1;
      bool struck = false;
      drop(1, {1, 1, 1}, {0, 0, 0}, e, parts, [&](auto& w) {
        w.for_each_local([&](const auto& cube) {
          const real height = cube.position()[2] - 0.5;
          struck = struck || height < 0.1;
          if (struck && cube.velocity()[2] > 0.1) top = std::max(top, height);
          lowest = std::min(lowest, height);
          turn = std::max(turn, cube.angular_velocity().norm());
        });
      });
      CHECK(struck);
      CHECK(turn < 0.01);  // it meets the floor at 5 m/s
      CHECK(top == doctest::Approx(e * e * 1.5).epsilon(0.02));
      CHECK(lowest > -1e-3);
    }
}

TEST_CASE("more parts of a step bring a divided heap nearer to rest") {
  divided::on(1, 0, [&](auto& w, bool) {
    double before = 1;
    for (const int parts : {1, 8, 64}) {
      w.solver().iterations = parts;
      for (int k = 0; k < 200; ++k) w.step(dt);
      const double now = measure_residual(w).value;
      MESSAGE(parts, " parts: residual ", now);
      CHECK(now < before);
      before = now;
    }
  });
}

TEST_CASE_TEMPLATE(
    "restitution: a ball bounces to e^2 of its height and rests in time, and one at rest stays",
    Solver, nonlinear_gauss_seidel, accelerated_jacobi, substepping) {
  using balls = scenario<bodies<sphere, plane>, transport<serial>, solver<Solver>>;
  for (const real e : {0.5, 0.9}) {
    CAPTURE(e);
    const auto fall_from = [&](real height, real step, auto&& each_step) {
      serial::link link;
      world<balls> w(link);
      w.material({.restitution = e, .friction = 0.5});
      w.gravity({0, 0, -g});
      w.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, 1}}, {}); });
      const auto ball = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0.5 + height}});
      for (int k = 1; each_step(k, w[ball]); ++k) w.step(step);
    };
    real error = 0;
    const real total = std::sqrt(2 / g) * (1 + e) / (1 - e);
    for (const real height : {1.0, 1.03, 1.07, 1.1}) {
      real last = 0;
      fall_from(height, dt, [&](int k, const auto& ball) {
        if (std::abs(ball.velocity()[2]) > 1e-9) last = k * dt;
        return k * dt < 1.5 * total * std::sqrt(height);
      });
      error += std::abs(last / (total * std::sqrt(height)) - 1) / 4;
    }
    MESSAGE(std::string(Solver::name), ", e = ", e, ": time to rest within ", error);
    CHECK(error < 0.05);
    real highest = 0;  // after the first bounce
    fall_from(1, dt / 16, [&](int k, const auto& ball) {
      if (k * dt / 16 > 1.05 * std::sqrt(2 / g))
        highest = std::max(highest, ball.position()[2] - 0.5);
      return k * dt / 16 < (1 + 1.5 * e) * std::sqrt(2 / g);
    });
    CHECK(highest == doctest::Approx(e * e).epsilon(0.01));
    fall_from(0, dt, [&](int k, const auto& ball) {
      CHECK(ball.velocity().norm() < 1e-12);
      CHECK(std::abs(ball.position()[2] - 0.5) < 1e-12);
      return k < 240;
    });
  }
}

TEST_CASE_TEMPLATE("restitution: five balls that fall into a crate come to rest and do not jitter",
                   Solver, nonlinear_gauss_seidel, accelerated_jacobi, substepping) {
  using balls = scenario<bodies<sphere, plane>, transport<serial>, solver<Solver>>;
  serial::link link;
  world<balls> w(link);
  w.material({.restitution = 0.9, .friction = 0.5});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) {
    scope.add(plane{.normal = {0, 0, 1}}, {});
    for (const int axis : {0, 1}) {
      scope.add(plane{.normal = vec3::Unit(axis)}, {});
      scope.add(plane{.normal = -vec3::Unit(axis), .offset = -2}, {});
    }
  });
  for (const real x : {0.5, 1.5})
    for (const real y : {0.5, 1.5})
      w.add(body{.shape = sphere{0.5}, .position = {x, y, 0.7 + 0.1 * x + 0.05 * y}});
  w.add(body{.shape = sphere{0.5}, .position = {1, 1, 1.9}});
  for (int k = 0; k < 15 * 240; ++k) w.step(dt);
  real fastest = 0;
  for (int k = 0; k < 240; ++k) {
    w.step(dt);
    fastest = std::max(fastest, measure_motion(w).max_speed);
  }
  MESSAGE(std::string(Solver::name), ": fastest in the last second ", fastest);
  CHECK(fastest < 1e-3 * g * dt);
}

TEST_CASE("the residual is what its definition says: two frictionless balls, one upon the other") {
  using balls = scenario<bodies<sphere, plane>, hard_contact<>, transport<serial>,
                         solver<accelerated_jacobi>, features<residual_monitor>>;
  serial::link link;
  world<balls> w(link);
  w.material({.density = 3});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, 1}}, {}); });
  const auto low = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0.5}});
  const auto high = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 1.5}});
  w.solver().iterations = 1;
  w.step(dt);
  const real m = w[low].mass(), v0 = w[low].velocity()[2], v1 = w[high].velocity()[2];
  // Both balls had -g dt; contacts: floor against low (impulse r0), low against high (r1).
  const real r1 = m * (v1 + g * dt), r0 = m * (v0 + g * dt) + r1, u0 = v0, u1 = v1 - v0;
  const real rho = 2 / (1 / m + 2 / m);
  const auto map = [&](real r, real u) { return r - std::max(real{0}, r - rho * u); };
  const real q = g * dt;  // of the floor's contact; the other one's is 0
  const real scale = std::max({std::hypot(r0, r1), rho * q, rho * std::hypot(u0, u1)});
  const real value = std::hypot(map(r0, u0), map(r1, u1)) / scale;
  const real worst = std::max(std::abs(map(r0, u0)), std::abs(map(r1, u1))) / scale * std::sqrt(2);
  CHECK(w.convergence().residual == doctest::Approx(value).epsilon(1e-12));  // recorded in the step
  const contact_residual found = measure_residual(w);
  CHECK(found.contacts == 2);
  CHECK(value > 0.01);
  CHECK(found.value == doctest::Approx(value).epsilon(1e-12));
  CHECK(found.max == doctest::Approx(worst).epsilon(1e-12));
}

TEST_CASE("the residual sees what the cone leaves out: sliding must oppose friction") {
  const vec3 n{0, 0, 1};
  const real mu = 0.5, rho = 2;
  const auto map = [&](const vec3& r, const vec3& u) {
    return detail::natural_map(r, u, n, mu, rho).norm();
  };
  CHECK(map({0, 0, 0}, {3, 0, 1}) == 0);        // separates
  CHECK(map({0.3, 0, 1}, {0, 0, 0}) == 0);      // sticks inside the cone
  CHECK(map({-0.5, 0, 1}, {4, 0, 0}) < 1e-15);  // slides, friction against it
  CHECK(map({0.5, 0, 1}, {4, 0, 0}) > 0.5);     // with it
  CHECK(map({-0.3, 0, 1}, {4, 0, 0}) > 0.1);    // slides inside the cone
  CHECK(map({-0.5, 0, 1}, {4, 0, 1}) > 0.5);    // separates under load
  CHECK(map({-0.5, 0, 1}, {4, 0, -1}) > 0.5);   // sinks
  CHECK(detail::natural_map({0.2, 0, 1}, {0, 0, 0}, n, 0, rho).norm() > 0.19);  // no friction
}

TEST_CASE("settings of the solver that make no sense are refused") {
  using balls = scenario<bodies<sphere>, transport<serial>>;
  serial::link link;
  world<balls> w(link);
  w.solver().tolerance = -1;
  CHECK_THROWS_WITH_AS(w.step(dt), doctest::Contains("tolerance of the solver"),
                       std::invalid_argument);
  w.solver() = {.tolerance = 1e-6, .max_iterations = 0};
  CHECK_THROWS_AS(w.step(dt), std::invalid_argument);
  w.solver() = {.tolerance = 1e-6};
  w.step(dt);  // nothing to solve
  CHECK(w.convergence().iterations == 0);
  CHECK(w.convergence().residual == 0);
}
