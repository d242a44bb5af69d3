// Machines of many kinds of joints over several ranks, on fixed bodies too, and from checkpoints.
// timeout: 300
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/fixed_joint.hpp>
#include <talus/constraint/gear.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/rod.hpp>
#include <talus/constraint/slider.hpp>
#include <talus/constraint/strut.hpp>
#include <talus/constraint/universal_joint.hpp>
#include <talus/constraint/weld.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/joints.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

using cells = grid<dynamic, dynamic>;
template <class Solver>
using machine = scenario<
    bodies<sphere, box>, talus::solver<Solver>, decomposition<cells>, transport<threads>,
    features<checkpoints>,
    joints<hinge, slider, fixed_joint, rod, universal_joint, weld, ball_joint, strut, gear>>;

struct scratch_file {
  std::string name = "/tmp/talus_machine_" + std::to_string(getpid()) + ".h5";
  ~scratch_file() { unlink(name.c_str()); }
};
[[nodiscard]] cells square_cells(int ranks) {
  const int x = ranks == 1 ? 1 : 2;
  return {.cells = {x, ranks / x}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
}

/// A chain of bricks over all domains, in free flight: its joints are of all kinds, and a motor
/// turns a brick at its end. Returns the hinge of the motor, and the weld, which breaks.
template <class World>
auto set_up(World& w) {
  using scene = typename World::scenario_type;
  const auto stuff = w.material({.density = 1, .restitution = 0.1, .friction = 0.4});
  std::optional<handle<box>> last;
  std::optional<joint_handle<scene, hinge>> wheel;
  std::optional<joint_handle<scene, weld>> seam;
  const auto place = [](int k) { return vec3(-3.1 + 0.7 * k, 0.3 * std::sin(k), 0.1 * k); };
  for (int k = 0; k < 10; ++k) {
    const auto next = w.add_if_local(body{.shape = box{.size = {0.5, 0.3, 0.2}},
                                          .position = place(k),
                                          .material = stuff,
                                          .velocity = {0.2 * std::sin(2.0 * k), 0.3, 0.1}});
    const vec3 between = k > 0 ? vec3(0.5 * (place(k - 1) + place(k))) : vec3(0, 0, 0);
    switch (k) {
      case 0:
        break;
      case 1:
      case 6:
        (void)w.join(last, next, hinge{.at = between, .limits = {-0.2, 0.3}});
        break;
      case 2:
        (void)w.join(last, next,
                     slider{.at = between,
                            .axis = {1, 0, 0},
                            .limits = {-0.1, 0.1},
                            .spring = {.stiffness = 2, .damping = 0.1}});
        break;
      case 3:
        (void)w.join(last, next, fixed_joint{.at = between});
        break;
      case 4:
        (void)w.join(
            last, next,
            universal_joint{.at = between, .first_axis = {0, 0, 1}, .second_axis = {0, 1, 0}});
        break;
      case 5:
        (void)w.join(last, next, rod{.from = place(4) + vec3(0.2, 0, 0), .to = place(5)});
        break;
      case 7:
        seam = w.join(last, next, weld{.at = between, .largest_force = 0.35});
        break;
      case 8:
        (void)w.join(last, next, hinge{.at = between, .friction = 1e-3});
        break;
      default:
        wheel = w.join(last, next,
                       hinge{.at = place(9),
                             .axis = {1, 0, 0},
                             .motor = {.velocity = 12, .largest_torque = 0.01}});
    }
    last = next;
  }
  return std::pair(*wheel, *seam);
}

struct outcome {
  std::string digest;
  vec3 before{0, 0, 0}, after{0, 0, 0};
  real angle = 0;  ///< of the wheel
  real seams = 0;  ///< ranks that hold the weld at the end, and at the beginning
  real at_first = 0;
};
template <class Solver>
outcome run(int ranks, const std::string& file, bool write, bool read) {
  outcome result;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<machine<Solver>> w(link, square_cells(ranks));
    const auto [wheel, seam] = set_up(w);
    if (read) CHECK(read_checkpoint(w, file) == "");
    w.synchronize();
    const vec3 before = measure_motion(w).momentum;
    std::array<double, 3> sums{};
    sums[2] = seam.known();
    for (int k = read ? 500 : 0; k < 1000; ++k) {
      if (k == 500 && write) write_checkpoint(w, file);
      w.step(1e-3);
    }
    sums[1] = seam.known();
    w.link().reduce(reduction::sum, std::span<double>(sums));
    std::array<double, 1> angle{wheel.known() ? wheel.angle() : -1e9};
    w.link().reduce(reduction::max, std::span<double>(angle));
    const vec3 after = measure_motion(w).momentum;
    const std::string digest = state_digest(w);
    if (link.rank() == 0) result = {digest, before, after, angle[0], sums[1], sums[2]};
  });
  return result;
}

/// What a scene does: before each step, and in the end a number that is the same on all ranks.
struct acts {
  std::function<void(int)> before = [](int) {};
  std::function<double()> measure = [] { return 0.0; };
};
struct course {
  std::vector<std::string> digests;  ///< of every 20 steps
  double number = 0;
};
/// A scene on x times y ranks, with cuts at x = 0, or at -4/3 and 4/3, and y = 0.
template <class Solver, class SetUp>
course follow(std::array<int, 2> size, int steps, real dt, SetUp&& set_up) {
  course result;
  threads::launch({.ranks = size[0] * size[1]}, [&](threads::link& link) {
    const cells domains{
        .cells = {size[0], size[1]}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
    world<machine<Solver>> w(link, domains);
    const acts scene = set_up(w, w.material({.density = 1, .restitution = 0.1, .friction = 0.4}));
    w.synchronize();
    course one;
    for (int k = 0; k < steps; ++k) {
      scene.before(k);
      w.step(dt);
      if (k % 20 == 19) one.digests.push_back(state_digest(w));
    }
    one.number = scene.measure();
    if (link.rank() == 0) result = one;
  });
  return result;
}
/// The course on one rank, after a check that it is the same on several ranks with either solver.
template <class SetUp>
course same_on_all(int steps, real dt, SetUp&& set_up) {
  const course one = follow<reproducible>({1, 1}, steps, dt, set_up);
  const course other = follow<nonlinear_gauss_seidel>({1, 1}, steps, dt, set_up);
  for (const std::array<int, 2> size : {std::array{2, 1}, {2, 2}, {3, 2}}) {
    CAPTURE(size[0] * size[1]);
    const course many = follow<reproducible>(size, steps, dt, set_up);
    CHECK(many.digests == one.digests);
    CHECK(many.number == one.number);
    const course by_default = follow<nonlinear_gauss_seidel>(size, steps, dt, set_up);
    CHECK(by_default.digests == other.digests);
    CHECK(by_default.number == other.number);
  }
  return one;
}

/// An arm of 0.8 turns about a fixed sphere near the corner of four ranks.
template <class World>
auto add_arm(World& w, material_id stuff, real spin, hinge how) {
  const auto post = w.add_if_local(
      body{.shape = sphere{0.05}, .position = {-0.02, -0.02, 0}, .material = stuff, .fixed = true});
  const auto arm = w.add_if_local(body{.shape = box{.size = {0.2, 0.1, 0.1}},
                                       .position = {0.78, -0.02, 0},
                                       .material = stuff,
                                       .velocity = {0, 0.8 * spin, 0},
                                       .angular_velocity = {0, 0, spin}});
  how.at = {-0.02, -0.02, 0};
  return w.join(post, arm, how);
}
/// A sphere to the right of a fixed one, which is on another rank if there are several.
template <class World>
auto add_welded(World& w, material_id stuff, real largest_force) {
  w.gravity({0, 0, -9.81});
  const auto post = w.add_if_local(
      body{.shape = sphere{0.1}, .position = {-0.2, 0.03, 0}, .material = stuff, .fixed = true});
  const auto ball =
      w.add_if_local(body{.shape = sphere{0.1}, .position = {0.4, 0.03, 0}, .material = stuff});
  return w.join(post, ball, weld{.at = {-0.2, 0.03, 0}, .largest_force = largest_force});
}
template <class World>
void release_fixed(World& w) {
  w.for_each_local([](auto b) {
    if (b.is_fixed()) b.release();
  });
}

}  // namespace

TEST_CASE(
    "with solver<reproducible> a machine has one digest on 1, 2 and 4 ranks, and from a checkpoint "
    "of any ranks") {
  const scratch_file file;
  const outcome one = run<reproducible>(1, file.name, false, false);
  CHECK(one.angle > 2 * pi);
  CHECK(one.at_first == 1);
  CHECK(one.seams == 0);
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    const outcome many = run<reproducible>(ranks, file.name, true, false);
    CHECK(many.digest == one.digest);
    CHECK(many.angle == one.angle);
    CHECK(many.seams == 0);
    CHECK((many.after - many.before).norm() < 1e-13 * (1 + many.before.norm()));
    for (const int readers : {1, 4}) {
      CAPTURE(readers);
      const outcome rest = run<reproducible>(readers, file.name, false, true);
      CHECK(rest.digest == one.digest);
      CHECK(rest.angle == one.angle);
    }
  }
}

TEST_CASE(
    "with the default solver it keeps its momentum and, without contacts, its digest on any ranks, "
    "and continues on as many") {
  const scratch_file file;
  const outcome one = run<nonlinear_gauss_seidel>(1, file.name, false, false);
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    const outcome whole = run<nonlinear_gauss_seidel>(ranks, file.name, true, false);
    CHECK(whole.digest == one.digest);
    CHECK((whole.after - whole.before).norm() < 1e-13 * (1 + whole.before.norm()));
    CHECK(whole.angle > 2 * pi);
    CHECK(whole.seams == 0);
    const outcome rest = run<nonlinear_gauss_seidel>(ranks, file.name, false, true);
    CHECK(rest.digest == whole.digest);
    CHECK(rest.angle == whole.angle);
  }
}

TEST_CASE("a hinge on a fixed body counts its turns and keeps its energy, whoever owns its arm") {
  const course driven = same_on_all(2000, 5e-3, [](auto& w, auto stuff) {
    const auto pin = add_arm(w, stuff, 0, hinge{.motor = {.velocity = 5, .largest_torque = 100}});
    return acts{.measure = [&w, pin] { return measure_joint(w, pin).angle; }};
  });
  CHECK(driven.number == doctest::Approx(50).epsilon(1e-3));
  const course wound = same_on_all(600, 5e-3, [](auto& w, auto stuff) {
    (void)add_arm(w, stuff, 20, hinge{.spring = {.stiffness = 0.05}});
    const auto most = std::make_shared<double>(0);
    return acts{
        .before =
            [&w, most](int) { *most = std::max(*most, double(measure_motion(w).kinetic_energy)); },
        .measure = [most] { return *most; }};
  });
  const real inertia = 0.002 * (0.8 * 0.8 + (0.2 * 0.2 + 0.1 * 0.1) / 12);
  CHECK(wound.number <= 0.5 * inertia * 20 * 20 * (1 + 1e-12));
}

TEST_CASE("a pendulum on a fixed sphere has one digest, fixed before or after it is joined") {
  for (const bool later : {false, true}) {
    CAPTURE(later);
    const course pendulum = same_on_all(600, 5e-3, [&](auto& w, auto stuff) {
      w.gravity({0, 0, -9.81});
      std::optional<handle<sphere>> last, post;
      for (const real x : {-0.1, -0.7, -1.3}) {
        const auto next = w.add_if_local(body{.shape = sphere{0.1},
                                              .position = {x, x < -1 ? 0.13 : 0.03, 0},
                                              .material = stuff,
                                              .fixed = x > -0.5 && !later});
        if (x > -0.5)
          post = next;
        else
          (void)w.join(last, next, ball_joint{.at = {x + 0.6, 0.03, 0}});
        last = next;
      }
      return acts{.before = [&w, post, later](int k) {
        if (later && k == 0 && post) w[*post].fix();
      }};
    });
    CHECK(pendulum.digests.size() == 30);
  }
}

TEST_CASE("a fixed body that is released falls with what is joined to it") {
  // Of one sphere in 50 steps. The weld breaks in the first one, and the other sphere falls.
  const real alone = -4.0 / 3 * pi * 1e-3 * 9.81 * 50 * 5e-3;
  for (const real largest_force : {1e-3, 1e3}) {
    CAPTURE(largest_force);
    const course fall = same_on_all(60, 5e-3, [&](auto& w, auto stuff) {
      const auto seam = add_welded(w, stuff, largest_force);
      return acts{.before =
                      [&w](int k) {
                        if (k == 10) release_fixed(w);
                      },
                  .measure = [&w, seam] { return measure_motion(w).momentum[2]; }};
    });
    CHECK(fall.number == doctest::Approx(alone * (largest_force < 1 ? 109 / 50.0 : 2)));
  }
}

TEST_CASE("a fixed body of another rank can be destroyed when its weld has broken, not before") {
  for (const bool breaks : {true, false}) {
    CAPTURE(breaks);
    const course rest = same_on_all(40, 5e-3, [&](auto& w, auto stuff) {
      const auto seam = add_welded(w, stuff, breaks ? 1e-3 : 1e3);
      const auto remove = [&w] { w.destroy_if([](const auto& b) { return b.is_fixed(); }); };
      return acts{.before =
                      [&w, remove, breaks](int k) {
                        if (k != 20) return;
                        bool here = false;
                        w.for_each_local([&](const auto& b) { here = here || b.is_fixed(); });
                        if (breaks || !here)
                          remove();
                        else
                          CHECK_THROWS_WITH(remove(), doctest::Contains("while it has a joint"));
                      },
                  .measure = [&w, seam] { return double(measure_joint(w, seam).exists); }};
    });
    CHECK(rest.number == !breaks);
  }
}

TEST_CASE("two bodies may have joints of different kinds") {
  for (const int kinds : {0, 1, 2}) {
    CAPTURE(kinds);
    (void)same_on_all(100, 1e-3, [&](auto& w, auto stuff) {
      const auto a = w.add_if_local(body{.shape = sphere{0.1},
                                         .position = {-0.3, 0.03, 0},
                                         .material = stuff,
                                         .velocity = {0, 0.3, 0.1}});
      const auto b = w.add_if_local(body{.shape = sphere{0.1},
                                         .position = {0.3, 0.03, 0},
                                         .material = stuff,
                                         .velocity = {0, -0.2, 0}});
      const strut spring{.from = {-0.3, 0.1, 0}, .to = {0.3, 0.2, 0}, .spring = {.stiffness = 1}};
      if (kinds == 0) (void)w.join(a, b, rod{.from = {-0.3, 0.1, 0}, .to = {0.3, 0.1, 0}});
      if (kinds == 1) (void)w.join(b, a, spring);
      if (kinds < 2) (void)w.join(a, b, ball_joint{});
      if (kinds == 2) (void)w.join(a, b, hinge{}), (void)w.join(a, b, spring);
      return acts{};
    });
  }
}

TEST_CASE("a rank that knows a gear only as part of an island turns it with the same bits") {
  const course train = same_on_all(400, 2e-3, [](auto& w, auto stuff) {
    const auto add = [&](const vec3& at, const vec3& velocity, const vec3& spin) {
      return w.add_if_local(body{.shape = box{.size = {0.02, 0.03, 0.04}},
                                 .position = at,
                                 .material = stuff,
                                 .velocity = velocity,
                                 .angular_velocity = spin});
    };
    const auto a = add({-0.45, 1.07, -0.22}, {-0.4, -0.3, -0.2}, {1.5, -1, 0.5});
    const auto b = add({1.09, 0.8, -0.82}, {0.3, -0.2, 0.4}, {-0.3, 1.2, 1.7});
    const auto c = add({0.06, -0.17, -0.44}, {0.2, 0.1, -0.3}, {0.9, 0.4, -1.1});
    (void)w.join(a, b,
                 gear{.first_axis = {0.3, -0.2, 1}, .second_axis = {1, 0.4, 0.2}, .ratio = 1.3});
    (void)w.join(b, c, ball_joint{.at = {0.8, 0.5, -0.7}});
    (void)w.join(world_frame, c, gear{.second_axis = {0.1, 0.3, 1}, .ratio = 0.7});
    return acts{};
  });
  CHECK(train.digests.size() == 20);
}
