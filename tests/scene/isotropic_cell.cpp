// Three walls press on a cell of grains at once: isotropic compaction to 100 kPa, in SI units.
// timeout: 300
#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/residual.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/scene/run.hpp>
#include <vector>

using namespace talus;

namespace {

using cell = scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
                      integrator<velocity_verlet>, decomposition<grid<dynamic, dynamic>>,
                      transport<threads>, features<checkpoints, driven>>;

struct held {
  int code = 0;
  std::string digest;
  std::uint64_t steps = 0;
  real worst = 0;       ///< relative error of a pressure, from the first equilibrium on
  real unbalanced = 0;  ///< force on the grains in relation to those of contacts
};

/// Compacts grains to 100 kPa until forces balance, and holds the pressures for 2,000 steps. An
/// error ends the run after step `fails`.
held compact(int ranks, std::vector<std::string> more, std::uint64_t fails = 0) {
  more.insert(more.begin(), {"cell", "--quiet", "--ranks", std::to_string(ranks)});
  std::vector<char*> argv;
  for (std::string& w : more) argv.push_back(w.data());
  held out;
  out.code = run<cell>(static_cast<int>(argv.size()), argv.data(), [&](auto& w, const auto&) {
    constexpr real p = 1e5, d = 0.005, L = 6.25 * d, dt = 1.2e-6;
    const int rows = w.ranks() % 2 == 0 ? 2 : 1;
    w.decompose({.cells = {w.ranks() / rows, rows}, .lower = {0, 0}, .upper = {0.8 * L, 0.8 * L}});
    const auto glass = w.material({.density = 2600, .stiffness = 400 * p * d});
    const auto smooth = w.material({.stiffness = rigid});
    w.material_pair(glass, smooth, {.restitution = 0.1});
    w.material_pair(glass, glass, {.restitution = 0.1, .friction = 0.2});
    std::array<handle<plane>, 3> walls;
    w.global([&](auto& s) {
      for (int k = 0; k < 3; ++k) {
        vec3 n(0, 0, 0);
        n[k] = 1;
        s.add(plane{.normal = n}, smooth);
        walls[std::size_t(k)] = s.add(plane{.normal = -n, .offset = -L}, smooth);
      }
    });
    const vec3 ones(1, 1, 1);
    w.fill(simple_cubic{.spacing = 1.25 * d, .origin = 0.625 * d * ones} &
               box_region{{0, 0, 0}, L * ones},
           [&](const site& place, random_stream& random) {
             return body{.shape = sphere{random.uniform(0.4 * d, 0.6 * d)},
                         .position = place.position,
                         .material = glass,
                         .velocity = random.uniform(-ones, ones)};
           });
    const auto size = [&](int k) { return -w[walls[std::size_t(k)]].shape().offset; };
    const auto error = [&] {
      real worst = 0;
      for (int k = 0; k < 3; ++k) {
        const real area = size((k + 1) % 3) * size((k + 2) % 3);
        worst =
            std::max(worst, std::abs(contact_force(w, walls[std::size_t(k)])[k] / (area * p) - 1));
      }
      return worst;
    };
    w.after_each_step([&, fails] {
      if (w.steps() == fails) throw std::runtime_error("it fails");
    });
    for (const auto wall : walls) w.hold_force(wall, {.pressure = p, .max_speed = 3});
    const auto balanced = [&] { return error() < 0.01 && measure_residual(w).value < 1e-2; };
    w.simulate({.steps = 60000, .dt = dt, .stop_when = balanced, .check_every = 200});
    real worst = 0;
    w.keep("worst", worst);
    w.observe(every{10}, [&](auto&) { worst = std::max(worst, error()); });
    w.simulate({.steps = 2000, .dt = dt});
    const std::string digest = state_digest(w);
    const real unbalanced = measure_residual(w).value;
    if (w.rank() == 0) out = {0, digest, w.steps(), worst, unbalanced};
  });
  return out;
}

}  // namespace

TEST_CASE("three walls hold a pressure at once, on any ranks and after a restart") {
  const std::string file = "/tmp/talus_cell_" + std::to_string(getpid()) + ".h5";
  const held one = compact(1, {});
  CHECK(one.code == 0);
  CHECK(one.steps < 20000);
  CHECK(one.worst < 0.02);
  CHECK(one.unbalanced < 0.01);
  const auto same = [&](const held& other) {
    CHECK(other.code == 0);
    CHECK(other.digest == one.digest);
    CHECK(other.steps == one.steps);
    CHECK(other.worst == doctest::Approx(one.worst).epsilon(1e-9));
  };
  for (const int ranks : {2, 4}) same(compact(ranks, {}));
  // Restarted while the walls compact, and while they hold.
  for (const std::uint64_t ends : {std::uint64_t{3500}, one.steps - 500}) {
    CHECK(compact(1, {"--checkpoint", file, "--checkpoint-every", "1000"}, ends).code == 1);
    same(compact(2, {"--restart", file}));
    unlink(file.c_str());
  }
}
