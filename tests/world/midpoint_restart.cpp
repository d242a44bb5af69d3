// Impacts and fields in the middle of the step, by colours: the same bits on any ranks and after
// restarts.
#include <doctest/doctest.h>

#include <unistd.h>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/force_field.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using bouncing =
    scenario<bodies<sphere, box, plane>, solver<reproducible>, integrator<moreau_midpoint>,
             transport<threads>, decomposition<grid<dynamic, dynamic>>,
             hard_contact<coulomb_friction, newton_restitution>,
             features<checkpoints, driven, forces>>;

/// A box of planes, the floor of which shakes.
void add_walls(world<bouncing>& w) {
  w.decompose({.lower = {0, 0}, .upper = {4, 4}});
  w.gravity({0, 0, -9.81});
  const auto m = w.material({.restitution = 0.7, .friction = 0.3});
  w.global([&](auto& scope) {
    const auto floor = scope.add(plane{}, m);
    for (const vec3& n : {vec3(1, 0, 0), vec3(0, 1, 0)})
      scope.add(plane{n, 0}, m), scope.add(plane{-n, -4}, m);
    scope.drive(floor, oscillation{.amplitude = {0, 0, 0.05}, .frequency = 5});
  });
  add_force_field(w, [](const vec3& x, real t) {  // towards a place that goes round
    return vec3(2 + portable::cos(t), 2 + portable::sin(t), 1) - x;
  });
}
void add_bodies(world<bouncing>& w) {
  random_stream random(11);
  for (int i = 0; i < 72; ++i) {
    const vec3 at = vec3(0.5, 0.5, 0.7) + 0.6 * vec3(i % 6, i / 6 % 6, i / 36);
    const vec3 v = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
    if (i % 3 == 0)
      w.add_if_local(body{.shape = box{{0.3, 0.35, 0.4}}, .position = at, .velocity = v});
    else
      w.add_if_local(body{.shape = sphere{0.25}, .position = at, .velocity = v});
  }
  w.synchronize();
}
/// The digest after step 400, and a checkpoint of step 200 if it has a name.
std::string digest_of(int ranks, const std::string& read, const std::string& write) {
  std::string digest;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<bouncing> w(link);
    add_walls(w);
    if (read.empty())
      add_bodies(w);
    else
      read_checkpoint(w, read);
    while (w.steps() < 400) {
      if (w.steps() == 200 && !write.empty()) write_checkpoint(w, write);
      w.step(1.0 / 240);
    }
    const std::string found = state_digest(w);
    if (link.rank() == 0) digest = found;
  });
  return digest;
}

}  // namespace

TEST_CASE(
    "impacts on a shaking floor in a field have the same bits on any ranks and after restarts") {
  const std::string file = "/tmp/talus_midpoint_" + std::to_string(getpid()) + ".h5";
  const std::string digest = digest_of(2, "", file);
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    CHECK(digest_of(ranks, "", "") == digest);
    CHECK(digest_of(ranks, file, "") == digest);
  }
  unlink(file.c_str());
}
