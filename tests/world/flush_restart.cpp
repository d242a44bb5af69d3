// Flush fixed bodies are one surface after a restart on other ranks, and while cuts move.
#include <doctest/doctest.h>
#include <unistd.h>

#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/balance.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/bisection.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/nonlinear_gauss_seidel.hpp>
#include <utility>
#include <vector>

#include "../flush_scene.hpp"

using namespace talus;

namespace {

template <class Solver>
using moved =
    scenario<bodies<sphere, box, triangle_mesh>, solver<Solver>, decomposition<bisection<dynamic>>,
             transport<threads>, features<checkpoints, balancing>>;

struct course {
  int before = 1, after = 1;  ///< ranks before the restart and after it
  bool fixed = false;         ///< the boxes are bodies of their ranks
  bool balanced = false;
};
/// The digest after sliders have gone over the tiles. The run is restarted while cubes and spheres
/// are over the seam at x = 0.
template <class Solver>
std::string slid(const course& c) {
  const std::string file = "/tmp/talus_flush_restart_" + std::to_string(getpid()) + ".h5";
  std::string digest;
  const auto run = [&](int ranks, bool restarts, int steps) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<moved<Solver>> w(link, {.lower = {-1, -1}, .upper = {1, 1}});
      without_friction(w);
      w.solver().iterations = 20;  // see "Flush surfaces" in docs/policies/shapes.md
      if (!c.fixed) put_tiles(w, false);
      put_rims(w);
      if (restarts) {
        read_checkpoint(w, file);
      } else {
        if (c.fixed) put_tiles(w, true);
        put_sliders(w);
      }
      if (c.balanced) w.balance({.every = 5, .above = 1.02});
      for (int k = 0; k < steps; ++k) {
        w.step(1.0 / 240);
        CAPTURE(k);
        CAPTURE(restarts);
        CAPTURE(ranks);
        check_sliders(w, 1e-6);
      }
      (void)w.audit();
      if (!restarts) write_checkpoint(w, file);
      const auto all = state_digest(w);
      if (link.rank() == 0) digest = all;
    });
  };
  run(c.before, false, 74), run(c.after, true, 46);
  unlink(file.c_str());
  return digest;
}

using soft =
    scenario<bodies<sphere, box, triangle_mesh>,
             soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>,
             decomposition<grid<dynamic, dynamic>>, transport<threads>, features<checkpoints>>;

/// The digest after soft spheres and boxes have gone over the triangles of two meshes and over
/// tiles. The run is restarted on the way.
std::string rolled(const course& c) {
  const std::string file = "/tmp/talus_soft_restart_" + std::to_string(getpid()) + ".h5";
  std::string digest;
  const auto run = [&](int ranks, bool restarts, int steps) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<soft> w(link, {.lower = {-1, -1}, .upper = {1, 1}});
      w.gravity({0, 0, -9.81});
      w.material({.density = 1000,
                  .restitution = 0.3,
                  .friction = 0.5,
                  .youngs_modulus = 1e6,
                  .poisson_ratio = 0.3,
                  .rolling_friction = 0.05});
      for (const real y : {-1.0, -0.5}) {
        std::vector<triangle_mesh::triangle> all;
        for (int i = -20; i < 20; ++i) {
          const real x = 0.05 * i;
          const vec3 a(x, y, 0), b(x + 0.05, y, 0), e(x + 0.05, y + 0.5, 0), d(x, y + 0.5, 0);
          all.push_back({a, b, e}), all.push_back({a, e, d});
        }
        w.global([&](auto& s) {
          const triangle_mesh m(all);
          const pose at = placed(m);
          s.add(body<triangle_mesh>{
              .shape = m, .position = at.position, .orientation = at.orientation});
        });
      }
      if (restarts) read_checkpoint(w, file);
      for (int i = -4; i < 4; ++i) {
        const body<box> tile{.shape = box{{0.25, 1, 0.2}},
                             .position = {0.25 * i + 0.125, 0.5, -0.1},
                             .fixed = c.fixed};
        if (!c.fixed) w.global([&](auto& s) { s.add(tile); });
        if (c.fixed && !restarts) w.add_if_local(tile);
      }
      for (int k = 0; k < 24 && !restarts; ++k) {
        const vec3 at(-0.8 + 0.3 * (k % 6), -0.75 + 0.42 * (k / 6), 0), v(0.4 + 0.02 * k, 0.1, 0);
        if (k % 3 == 0)
          w.add_if_local(body{.shape = box{{0.1, 0.14, 0.06}},
                              .position = at + vec3(0, 0, 0.0299),
                              .velocity = v,
                              .orientation = rotation({0, 0, 1}, 0.1 * k)});
        else
          w.add_if_local(body{.shape = sphere{0.05},
                              .position = at + vec3(0, 0, 0.0499),
                              .velocity = v,
                              .angular_velocity = {0, 8, 0}});
      }
      for (int k = 0; k < steps; ++k) w.step(2e-4);
      (void)w.audit();
      if (!restarts) write_checkpoint(w, file);
      const auto all = state_digest(w);
      if (link.rank() == 0) digest = all;
    });
  };
  run(c.before, false, 700), run(c.after, true, 500);
  unlink(file.c_str());
  return digest;
}

}  // namespace

TEST_CASE("soft bodies on meshes and tiles move alike on any ranks and after a restart") {
  for (const bool fixed : {false, true}) {
    CAPTURE(fixed);
    const auto one = rolled({.fixed = fixed});
    for (const auto& [before, after] : {std::pair{2, 2}, {4, 4}, {4, 1}, {1, 3}})
      CHECK(rolled({before, after, fixed, false}) == one);
  }
}

TEST_CASE("bodies slide over seams after a restart on other ranks, with cuts that move or not") {
  for (const bool fixed : {false, true}) {
    CAPTURE(fixed);
    const auto one = slid<reproducible>({.fixed = fixed});
    for (const bool balanced : {false, true}) {
      CAPTURE(balanced);
      CHECK(slid<reproducible>({1, 4, fixed, balanced}) == one);
      CHECK(slid<reproducible>({4, 1, fixed, balanced}) == one);
      CHECK(slid<reproducible>({4, 3, fixed, balanced}) == one);
      slid<nonlinear_gauss_seidel>({1, 4, fixed, balanced});
      slid<nonlinear_gauss_seidel>({4, 1, fixed, balanced});
    }
  }
}
