// A packing whose radii grow in rounds, through tables, until no room is left: alike on any ranks.
#include <doctest/doctest.h>
#include <unistd.h>

#include <string>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/packing.hpp>
#include <talus/scene/region.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

using namespace talus;

TEST_CASE("radii grow in rounds until no room is left") {
  using scene = scenario<bodies<sphere, plane>, solver<reproducible>, transport<threads>,
                         decomposition<grid<dynamic>>>;
  const std::string file = "/tmp/talus_growing_" + std::to_string(getpid()) + ".csv";
  std::string digest;
  for (const int ranks : {1, 2})
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<scene> world(link, {.lower = {0}, .upper = {4}});
      const auto stone = world.material({.density = 2, .restitution = 0.3});
      world.global([&](auto& scope) {
        for (const vec3& n : {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)}) {
          scope.add(plane{.normal = n}, stone);
          scope.add(plane{.normal = -n, .offset = -4}, stone);
        }
      });
      world.fill(
          simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0.5}} & box_region{{0, 0, 0}, {4, 4, 4}},
          [&](const site& place, random_stream& random) {
            return body{.shape = sphere{random.uniform(0.25, 0.35)},
                        .position = place.position,
                        .material = stone,
                        .velocity = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1))};
          });
      const auto resize = [&](double factor) {
        write_packing(world, file);
        const packing now = read_packing(file);
        world.destroy_if([](const auto& b) { return !b.is_fixed(); });
        world.fill(now, [&](const site& place, random_stream& random) {
          return body{.shape = sphere{factor * now[place.index].radius},
                      .position = place.position,
                      .material = stone,
                      .velocity = random.uniform(-1, 1) * random.unit_vector()};
        });
      };
      for (double growth = 0.02; growth > 1e-3;) {
        resize(1 + growth);
        for (int n = 0; n < 100; ++n) world.step(0.005);
        if (measure_penetration(world).max < 0.01) continue;
        resize(1 / (1 + growth)), growth /= 2;  // no room for so much
      }
      for (int n = 0; n < 100; ++n) world.step(0.005);
      const double solid = measure_motion(world).mass / 2 / 64;
      CHECK(solid > 0.5);
      CHECK(measure_penetration(world).max < 0.01);
      const std::string now = state_digest(world);
      if (world.rank() == 0 && ranks == 1) digest = now;
      if (world.rank() == 0) CHECK(now == digest);
    });
  unlink(file.c_str());
}
