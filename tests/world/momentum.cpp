// Momentum across ranks: the momentum that one rank loses, another one gains.
#include <doctest/doctest.h>

#include "collision_cloud.hpp"

using namespace talus;

TEST_CASE(
    "a gravity-free cloud of colliding spheres conserves linear and angular momentum to round-off "
    "on 1, 2, 4 and 9 ranks") {
  using cloud = collision_cloud<transport<threads>, no_correction>;
  for (const int ranks : {1, 2, 4, 9}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      const auto [before, after, collided] = cloud::run(link, 400);
      if (link.rank() != 0) return;
      CHECK(after.bodies == before.bodies);
      CHECK(collided > 100);
      CHECK((after.momentum - before.momentum).norm() < 1e-13 * cloud::momentum_scale(before));
      CHECK((after.angular_momentum - before.angular_momentum).norm() <
            1e-12 * cloud::momentum_scale(before) * cloud::extent);
      CHECK(after.kinetic_energy < before.kinetic_energy);
    });
  }
}

TEST_CASE(
    "with position correction the linear momentum of the cloud is conserved to round-off too") {
  using cloud = collision_cloud<transport<threads>, split_correction>;
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      const auto [before, after, collided] = cloud::run(link, 400);
      if (link.rank() != 0) return;
      CHECK(collided > 100);
      CHECK((after.momentum - before.momentum).norm() < 1e-13 * cloud::momentum_scale(before));
    });
  }
}

TEST_CASE("the initial state of the cloud is the same to the bit for every number of ranks") {
  using cloud = collision_cloud<transport<threads>, split_correction>;
  std::vector<std::string> digests;
  for (const int ranks : {1, 2, 4, 6, 9})
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<cloud::scenario_type> w(link, cloud::cells());
      cloud::set_up(w);
      const auto digest = state_digest(w);
      if (link.rank() == 0) digests.push_back(digest);
    });
  for (const auto& d : digests) CHECK(d == digests[0]);
}
