// A machine of many kinds of joints over several ranks, and from checkpoints.
// timeout: 300
#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/constraint/fixed_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/rod.hpp>
#include <talus/constraint/slider.hpp>
#include <talus/constraint/universal_joint.hpp>
#include <talus/constraint/weld.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/joints.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/summary.hpp>
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
using machine =
    scenario<bodies<sphere, box>, talus::solver<Solver>, decomposition<cells>, transport<threads>,
             features<checkpoints>, joints<hinge, slider, fixed_joint, rod, universal_joint, weld>>;

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

TEST_CASE("with the default solver it keeps its momentum on any ranks, and continues on as many") {
  const scratch_file file;
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    const outcome whole = run<nonlinear_gauss_seidel>(ranks, file.name, true, false);
    CHECK((whole.after - whole.before).norm() < 1e-13 * (1 + whole.before.norm()));
    CHECK(whole.angle > 2 * pi);
    CHECK(whole.seams == 0);
    const outcome rest = run<nonlinear_gauss_seidel>(ranks, file.name, false, true);
    CHECK(rest.digest == whole.digest);
    CHECK(rest.angle == whole.angle);
  }
}

TEST_CASE("a joint that its anchors tear open is named in a warning, on any ranks alike") {
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<machine<nonlinear_gauss_seidel>> w(link, square_cells(ranks));
      const auto stuff = w.material({.density = 1});
      const auto ball = [&](const vec3& at, bool fixed) {
        return w.add_if_local(
            body{.shape = sphere{0.2}, .position = at, .material = stuff, .fixed = fixed});
      };
      const auto left = ball({-0.8, 0.3, 0}, true), right = ball({0.8, 0.3, 0}, true),
                 middle = ball({0.1, 0.3, 0}, false);
      (void)w.join(left, middle, hinge{.at = {-0.4, 0.3, 0}});
      (void)w.join(middle, right, hinge{.at = {0.4, 0.3, 0}});
      for (int k = 1; k <= 20; ++k) {
        if (right) w[*right].translate({0.01, 0, 0});
        w.step(1e-2);
      }
      const joint_errors errors = measure_joints(w);
      CHECK(errors.joints == 2);
      CHECK(errors.gap == doctest::Approx(0.1).epsilon(0.01));
      const detail::open_joint worst = detail::worst_open_joint(w);
      CHECK(worst.step == 20);
      CHECK(worst.gap == doctest::Approx(0.1).epsilon(0.01));
      const std::string said = detail::warnings_of_scales({.bodies = 3,
                                                           .movable = 1,
                                                           .steps = 20,
                                                           .dt = 0.01,
                                                           .gravity = 10,
                                                           .radius = 1,
                                                           .joint = worst});
      CHECK(said.find("in step 20 the hinge of body ") != said.npos);
    });
  }
}
