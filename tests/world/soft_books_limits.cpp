// Entries of the energy ledger with soft contacts against closed forms. The ledger closes whatever
// the entries are; here each has its own value, and the entry of the scheme vanishes with the time
// step.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/energy.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

template <class Integrator>
using scene = scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
                       integrator<Integrator>, transport<threads>, features<energy_ledger>>;

constexpr real radius = 0.5, mass = pi / 6, stiffness = 1e5, restitution = 0.5, friction = 0.4;

template <class Integrator, class SetUp>
energy_balance run(real duration, real dt, SetUp&& set_up) {
  energy_balance b;
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<scene<Integrator>> w(link);
    w.material(
        {.density = 1, .restitution = restitution, .friction = friction, .stiffness = stiffness});
    set_up(w);
    w.simulate({.steps = static_cast<std::size_t>(std::lround(duration / dt)), .dt = dt});
    b = measure_energy(w);
    CHECK(b.worst < 1e-13);
  });
  return b;
}

/// The value that an entry tends to when the time step vanishes, if its error is of first order.
double limit(double coarse, double fine) { return 2 * fine - coarse; }

/// A sphere that slides on a plane until it rolls.
template <class Integrator>
energy_balance slide(real dt) {
  return run<Integrator>(0.12, dt, [](auto& w) {
    w.gravity({0, 0, -10});
    w.global([](auto& scope) { scope.add(plane{}, {}); });
    w.add_if_local(body{.shape = sphere{radius},
                        .position = {0, 0, radius - mass * 10 / stiffness},
                        .velocity = {1, 0, 0}});
  });
}
/// Two spheres that meet head-on, each at the speed 1.
template <class Integrator>
energy_balance bounce(real dt) {
  return run<Integrator>(0.02, dt, [](auto& w) {
    for (const real side : {-1.0, 1.0})
      w.add_if_local(body{.shape = sphere{radius},
                          .position = {side * (radius + 0.00123), 0, 0},
                          .velocity = {-side, 0, 0}});
  });
}

}  // namespace

TEST_CASE_TEMPLATE("a sphere that slides until it rolls loses its energy to friction", Integrator,
                   semi_implicit_euler, velocity_verlet) {
  const energy_flows coarse = slide<Integrator>(1e-4).total, fine = slide<Integrator>(5e-5).total;
  const double arm = radius - mass * 10 / stiffness, inertia = 0.4 * mass * radius * radius;
  const double lost = 0.5 / (1 / mass + arm * arm / inertia);
  CHECK(limit(coarse.friction, fine.friction) == doctest::Approx(lost).epsilon(1e-3));
  CHECK(std::abs(fine.impact) < 1e-6 * lost);
  CHECK(std::abs(coarse.scheme) < 0.01 * lost);
  CHECK(std::abs(fine.scheme) < 0.6 * std::abs(coarse.scheme));
}

TEST_CASE_TEMPLATE("two spheres that rebound lose their energy to dashpots", Integrator,
                   semi_implicit_euler, velocity_verlet) {
  const energy_flows coarse = bounce<Integrator>(2e-5).total, fine = bounce<Integrator>(1e-5).total;
  const double lost = mass * (1 - restitution * restitution);
  CHECK(limit(coarse.impact, fine.impact) == doctest::Approx(lost).epsilon(1e-3));
  CHECK(std::abs(fine.friction) < 1e-15 * lost);
  CHECK(std::abs(coarse.scheme) < 0.02 * lost);
  CHECK(std::abs(fine.scheme) < 0.6 * std::abs(coarse.scheme));
}
