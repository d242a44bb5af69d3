// A run with joints that continues from a checkpoint equals the one that wrote it, on any number of
// ranks.
// timeout: 300
#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/constraint/ball_joint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

using cells = grid<dynamic, dynamic>;
template <class Solver, class... Joints>
using scene = scenario<bodies<sphere, box, plane>, talus::solver<Solver>, decomposition<cells>,
                       transport<threads>, features<checkpoints, orientation>, Joints...>;
template <class Solver>
using swinging = scene<Solver, joints<ball_joint>>;

struct scratch_file {
  std::string name = "/tmp/talus_joint_checkpoint_" + std::to_string(getpid()) + ".h5";
  ~scratch_file() { unlink(name.c_str()); }
};

[[nodiscard]] cells square_cells(int ranks) {
  const int x = ranks == 1 ? 1 : 2;
  return {.cells = {x, ranks / x}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
}

/// A chain from the ceiling over all domains, that swings through a heap of boxes. Returns its
/// joints; the second of them is released.
template <class World>
auto set_up(World& w) {
  std::vector<joint_handle<typename World::scenario_type, ball_joint>> all;
  const auto stuff = w.material({.density = 1, .restitution = 0.1, .friction = 0.4});
  w.gravity({0, 0, -9.81});
  handle<sphere> ceiling;
  w.global([&](auto& scope) {
    scope.add(plane{.normal = {0, 0, 1}}, stuff);
    ceiling = scope.add(sphere{0.1}, stuff, vec3(-3, 0.2, 4));
  });
  std::optional<handle<sphere>> last = ceiling;
  for (int k = 0; k < 12; ++k) {
    const vec3 at(-2.5 + 0.5 * k, 0.2 + 0.4 * std::sin(k), 4);
    const auto next = w.add_if_local(body{.shape = sphere{0.2}, .position = at, .material = stuff});
    all.push_back(w.join(last, next, ball_joint{.at = at - vec3(0.25, 0, 0)}));
    last = next;
  }
  for (int k = 0; k < 12; ++k)
    w.add_if_local(body{.shape = box{.size = {0.4, 0.4, 0.4}},
                        .position = {-2.5 + 0.45 * k, 0.1 * (k % 3), 0.2},
                        .material = stuff});
  all[7].release();
  return all;
}

struct outcome {
  std::string digest;
  vec3 force{0, 0, 0};
  std::uint64_t held = 0;
};
/// Steps 0 to 600, or from those of a checkpoint; one is written after 300 steps if `write`.
template <class Solver>
outcome run(int ranks, const std::string& file, bool write, bool read) {
  outcome result;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<swinging<Solver>> w(link, square_cells(ranks));
    const auto all = set_up(w);
    if (read) CHECK(read_checkpoint(w, file) == "");
    for (int k = read ? 300 : 0; k < 600; ++k) {
      if (k == 100) w.gravity({0.5, 0, -9});  // the set-up of a restart does not know of it
      if (k == 300 && write) write_checkpoint(w, file);
      w.step(2e-3);
    }
    std::array<double, 4> sums{};
    for (const auto& joint : all) sums[3] += joint.known();
    if (all[0].known())  // on the rank of its movable body
      for (int k = 0; k < 3; ++k) sums[static_cast<std::size_t>(k)] = all[0].force()[k];
    w.link().reduce(reduction::sum, std::span<double>(sums));
    const std::string digest = state_digest(w);
    if (link.rank() == 0)
      result = {digest, {sums[0], sums[1], sums[2]}, static_cast<std::uint64_t>(sums[3])};
  });
  return result;
}

}  // namespace

TEST_CASE(
    "a chain continues to the bit from a checkpoint, with the gravity it had last, and with "
    "solver<reproducible> on any ranks") {
  const scratch_file file;
  for (const int writers : {1, 4}) {
    const outcome whole = run<reproducible>(writers, file.name, true, false);
    for (const int readers : {1, 2, 4}) {
      CAPTURE(writers);
      CAPTURE(readers);
      const outcome rest = run<reproducible>(readers, file.name, false, true);
      CHECK(rest.digest == whole.digest);
      CHECK(rest.force == whole.force);
      CHECK(whole.force.norm() > 1);
    }
    if (writers == 1) CHECK(whole.held == 11);
  }
}

TEST_CASE("with the default solver it does on as many ranks") {
  const scratch_file file;
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    const outcome whole = run<nonlinear_gauss_seidel>(ranks, file.name, true, false);
    const outcome rest = run<nonlinear_gauss_seidel>(ranks, file.name, false, true);
    CHECK(rest.digest == whole.digest);
    CHECK(rest.held == whole.held);
  }
}

TEST_CASE("a scenario without the joints of a checkpoint refuses it") {
  const scratch_file file;
  (void)run<reproducible>(1, file.name, true, false);
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<scene<reproducible>> w(link, square_cells(1));
    w.material({.density = 1, .restitution = 0.1, .friction = 0.4});
    CHECK_THROWS_WITH_AS((void)read_checkpoint(w, file.name),
                         doctest::Contains("joints<ball_joint>"), std::runtime_error);
  });
}
