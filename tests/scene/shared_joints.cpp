// Islands of joints that lie on several ranks: they are solved and moved as on one rank.
// timeout: 300
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

constexpr real g = 9.81;
using slices = grid<dynamic, dynamic>;
template <class Solver, class... Policies>
using scene =
    scenario<bodies<box>, talus::solver<Solver>, decomposition<slices>, transport<threads>,
             joints<ball_joint, hinge>, features<energy_ledger>, Policies...>;

[[nodiscard]] slices slices_of(int ranks) {
  return {.cells = {ranks, 1}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
}

constexpr int links = 16;
constexpr real length = 0.45;

/// A chain of boxes in the form of a V over x; the thickness of a link says which it is.
template <class World>
void add_chain(World& w, bool hangs, const vec3& velocity) {
  const auto stuff = w.material({.density = 1, .restitution = 0.1, .friction = 0.4});
  const real slope = 0.5;
  vec3 end(-0.5 * length * links * std::cos(slope), 0, 0);
  std::optional<handle<box>> last;
  for (int k = 0; k < links; ++k) {
    const quat turn = rotation({0, 1, 0}, 2 * k < links ? slope : -slope);
    const vec3 along = rotated(turn, vec3(length, 0, 0));
    const vec3 wave = hangs ? vec3(0, 0, 0) : vec3(0, 0.3 * std::sin(k), 0.2 * std::cos(k));
    const auto next = w.add_if_local(body{.shape = box{.size = {length, 0.1, 0.1 + 1e-3 * k}},
                                          .position = end + 0.5 * along,
                                          .material = stuff,
                                          .velocity = velocity + wave,
                                          .orientation = turn});
    if (k % 5 == 4)
      (void)w.join(last, next, hinge{.at = end, .axis = {0, 1, 0}});
    else if (k > 0)
      (void)w.join(last, next, ball_joint{.at = end});
    else if (hangs)
      (void)w.join(world_frame, next, ball_joint{.at = end});
    end += along;
    last = next;
  }
  if (hangs) (void)w.join(last, world_frame, ball_joint{.at = end});
}

/// Of each link its centre and its two ends, on all ranks.
template <class World>
std::vector<double> places_of(World& w) {
  std::vector<double> all(9 * links, 0);
  w.for_each_local([&](const auto& b) {
    const auto k = static_cast<std::size_t>(std::lround((b.shape().size[2] - 0.1) * 1e3));
    const vec3 half = rotated(b.orientation(), vec3(length / 2, 0, 0));
    for (std::size_t i = 0; i < 3; ++i) {
      const int axis = static_cast<int>(i);
      all[9 * k + i] = b.position()[axis];
      all[9 * k + 3 + i] = b.position()[axis] - half[axis];
      all[9 * k + 6 + i] = b.position()[axis] + half[axis];
    }
  });
  w.link().reduce(reduction::sum, std::span<double>(all));
  return all;
}
[[nodiscard]] double widest_gap(const std::vector<double>& places) {
  double gap = 0;
  for (std::size_t k = 9; k < places.size(); k += 9)
    for (std::size_t i = 0; i < 3; ++i)
      gap = std::max(gap, std::abs(places[k + 3 + i] - places[k - 9 + 6 + i]));
  return gap;
}

struct outcome {
  std::string digest;
  std::vector<double> places;
  double gap = 0;  ///< largest of all steps
  double closure = 0;
  double drift = 0;  ///< of the energy
  vec3 before{0, 0, 0}, after{0, 0, 0};
  std::array<double, 2> fewest{1e9, 1e9};  ///< links of a rank, at the start and the end
};
template <class Scenario>
outcome run(int ranks, int steps, bool hangs, const vec3& velocity = {0, 0, 0}) {
  outcome result;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, slices_of(ranks));
    if (hangs) w.gravity({0, 0, -g});
    add_chain(w, hangs, velocity);
    w.synchronize();
    outcome one;
    one.before = measure_motion(w).momentum;
    std::array<double, 2> held{};
    const auto count = [&] {
      double n = 0;
      w.for_each_local([&](const auto&) { n += 1; });
      return n;
    };
    held[0] = count();
    const auto energy = [&] { return measure_energy(w).kinetic + measure_energy(w).potential; };
    w.step(1e-3);
    const double first = energy();
    for (int k = 1; k < steps; ++k) {
      w.step(1e-3);
      if (k % 50 == 0) {
        one.gap = std::max(one.gap, widest_gap(places_of(w)));
        one.drift = std::max(one.drift, std::abs(energy() - first));
      }
    }
    held[1] = count();
    w.link().reduce(reduction::min, std::span<double>(held));
    one.fewest = held;
    one.places = places_of(w);
    one.gap = std::max(one.gap, widest_gap(one.places));
    one.closure = measure_energy(w).worst;
    one.after = measure_motion(w).momentum;
    one.digest = state_digest(w);
    if (link.rank() == 0) result = one;
  });
  return result;
}
[[nodiscard]] double distance(const outcome& a, const outcome& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.places.size(); ++i)
    most = std::max(most, std::abs(a.places[i] - b.places[i]));
  return most;
}

}  // namespace

TEST_CASE("a chain that hangs over 4 ranks keeps its joints, and moves as on one rank") {
  using swept = scene<nonlinear_gauss_seidel>;
  const outcome one = run<swept>(1, 1000, true);
  for (const int ranks : {2, 4}) {
    CAPTURE(ranks);
    const outcome many = run<swept>(ranks, 1000, true);
    CHECK(many.gap < 1e-10 * length);
    CHECK(many.fewest[0] > 0);
    CHECK(many.closure < 1e-12);
    CHECK(distance(one, many) < 1e-6);
  }
  CHECK(one.gap < 1e-10 * length);
}

TEST_CASE("with solver<reproducible> it has one digest on 1, 2, 4 and 7 ranks") {
  using coloured = scene<reproducible>;
  const outcome one = run<coloured>(1, 600, true);
  CHECK(one.gap < 1e-10 * length);
  CHECK(distance(one, run<scene<nonlinear_gauss_seidel>>(1, 600, true)) < 1e-6);
  for (const int ranks : {2, 4, 7}) {
    CAPTURE(ranks);
    const outcome many = run<coloured>(ranks, 600, true);
    CHECK(many.digest == one.digest);
    CHECK(many.gap < 1e-10 * length);
  }
}

TEST_CASE("with integrator<moreau_midpoint> it keeps its energy on 4 ranks, with the bits of one") {
  using midpoint = scene<reproducible, integrator<moreau_midpoint>>;
  const outcome one = run<midpoint>(1, 600, true), many = run<midpoint>(4, 600, true);
  CHECK(many.digest == one.digest);
  CHECK(many.drift < 1e-9);
  CHECK(many.gap < 1e-10 * length);
}

TEST_CASE("a flying chain migrates through 4 ranks, and keeps its joints and its momentum") {
  using swept = scene<nonlinear_gauss_seidel>;
  const outcome many = run<swept>(4, 1000, false, {2, 0.3, 0.1});
  CHECK(many.fewest[1] < many.fewest[0]);
  CHECK(many.gap < 1e-10 * length);
  CHECK((many.after - many.before).norm() < 1e-13 * many.before.norm());
}

TEST_CASE("the ledger of a body that its joints hold closes, though round-off alone moves it") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scene<nonlinear_gauss_seidel>> w(link, slices_of(1));
    const auto stuff = w.material({.density = 1});
    const auto one = w.add_if_local(body{.shape = box{.size = {0.3, 0.2, 0.1}},
                                         .position = {0.1, 0.2, 0.3},
                                         .material = stuff,
                                         .velocity = {0.3, -0.1, 0.2},
                                         .angular_velocity = {-0.5, 1.7, 1.9}});
    for (const vec3& at : {vec3(0.1, 0.2, 0.7), vec3(0.6, 0.1, 0.3), vec3(0, 0.9, 0.2)})
      (void)w.join(world_frame, one, ball_joint{.at = at});
    for (int k = 0; k < 100; ++k) w.step(0.005);
    const energy_balance e = measure_energy(w);
    CHECK(e.kinetic < 1e-20 * e.total.impact);
    CHECK(e.worst < 1e-12);
  });
}
