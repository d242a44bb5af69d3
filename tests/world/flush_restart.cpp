// Flush fixed bodies are one surface after a restart on other ranks, and while cuts move.
#include <doctest/doctest.h>
#include <unistd.h>

#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/balance.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/bisection.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/nonlinear_gauss_seidel.hpp>

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

}  // namespace

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
