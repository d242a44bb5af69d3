#pragma once
// Restarts of heaps of several scenarios: run in one piece and in two, on the same ranks and on
// others.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <variant>

namespace talus::restarts {

using clump = union_of<sphere, box>;
/// Every kind of column and table.
using pile =
    scenario<bodies<sphere, box, clump, plane>, hard_contact<coulomb_friction, newton_restitution>,
             decomposition<grid<dynamic, dynamic>>, transport<threads>,
             features<checkpoints, sleeping, user_ids, forces, damping>>;
using soft_pile = scenario<bodies<sphere, plane>,
                           soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>,
                           integrator<velocity_verlet>, decomposition<grid<dynamic, dynamic>>,
                           transport<threads>, features<checkpoints>>;

/// With contacts in the middle of the step.
using midpoint_pile =
    scenario<bodies<sphere, box, plane>, solver<reproducible>, integrator<moreau_midpoint>,
             decomposition<grid<dynamic, dynamic>>, transport<threads>, features<checkpoints>>;

using balls = scenario<bodies<sphere, plane>, decomposition<grid<dynamic, dynamic>>,
                       transport<threads>, features<checkpoints>>;

/// Such balls, whose trajectories do not depend on the number of ranks.
using same_balls =
    scenario<bodies<sphere, plane>, solver<reproducible>, decomposition<grid<dynamic, dynamic>>,
             transport<threads>, features<checkpoints>>;

/// Whether trajectories do not depend on the number of ranks. Add scenarios whose solver promises
/// that; the balls of run_course() touch only the ground.
template <class Scenario>
inline constexpr bool independent_of_ranks =
    std::is_same_v<Scenario, same_balls> || std::is_same_v<Scenario, midpoint_pile>;

/// A file of this process, removed at the end.
struct scratch_file {
  std::string name = "/tmp/talus_checkpoint_" + std::to_string(getpid()) + ".h5";
  ~scratch_file() { unlink(name.c_str()); }
};

/// The state of a run's end.
struct outcome {
  std::string digest;
  std::uint64_t bodies = 0, asleep = 0;
  double counted = 0, random = 0;
  bool operator==(const outcome&) const = default;
};

template <class Scenario>
auto a_body(const vec3& place, random_stream& random, material_id stone) {
  if constexpr (std::is_same_v<Scenario, pile>) {
    static const clump dumbbell{
        {{.shape = sphere{0.3}, .at = {{0.2, 0, 0}}}, {.shape = box{{0.4, 0.4, 0.3}}}}};
    const quat turn = random.rotation();
    std::variant<body<sphere>, body<box>, body<clump>> made;
    switch (random.integer(3)) {
      case 0:
        made = body{.shape = sphere{random.uniform(0.3, 0.48)},
                    .position = place,
                    .material = stone,
                    .user_id = 7};
        break;
      case 1:
        made = body{.shape = box{{0.5, random.uniform(0.4, 0.6), 0.5}},
                    .position = place,
                    .material = stone,
                    .orientation = turn};
        break;
      default:
        made = body{.shape = dumbbell, .position = place, .material = stone, .orientation = turn};
    }
    return made;
  } else if constexpr (std::is_same_v<Scenario, midpoint_pile>) {
    const quat turn = random.rotation();
    std::variant<body<sphere>, body<box>> made = body{
        .shape = box{{0.5, 0.6, 0.5}}, .position = place, .material = stone, .orientation = turn};
    if (random.integer(2) == 0)
      made = body{.shape = sphere{0.4}, .position = place, .material = stone};
    return made;
  } else if constexpr (std::is_same_v<Scenario, balls>) {
    return body{.shape = sphere{random.uniform(0.3, 0.4)},
                .position = place,
                .material = stone,
                .angular_velocity = 0.1 * random.unit_vector()};
  } else {
    return body{.shape = sphere{random.uniform(0.3, 0.48)}, .position = place, .material = stone};
  }
}

struct course {
  int ranks = 1;
  std::size_t from = 0, to = 0;  ///< steps
  std::size_t write_after = 0;   ///< a checkpoint after so many steps; 0: none
  double dt = 0.01;
};

/// Lets a heap fall; each step counts, draws a number, and adds a body now and then.
template <class Scenario>
outcome run_course(const course& c, const std::string& file) {
  outcome end;
  threads::launch({.ranks = c.ranks}, [&](auto& link) {
    world<Scenario> w(link);
    if (c.ranks > 1) w.decompose({.lower = {-2, -2}, .upper = {2, 2}});
    w.gravity({0, 0, -10});
    if constexpr (std::is_same_v<Scenario, pile>) {
      w.sleeping({.speed = 1, .time = 0.1});
      w.damping(0.2);
    }
    const auto stone = w.material({.density = 2,
                                   .restitution = 0.3,
                                   .friction = 0.5,
                                   .youngs_modulus = 1e5,
                                   .rolling_friction = 0.02});
    w.global([&](auto& scope) { scope.add(plane{}, stone); });
    // A part of the low pile is at rest before the first added body falls on it.
    constexpr real top = std::is_same_v<Scenario, balls>  ? 1
                         : std::is_same_v<Scenario, pile> ? 2
                                                          : 4;
    w.fill(simple_cubic{.spacing = 1} & box_region{{-2, -2, 0.5}, {2, 2, top}},
           [&](const site& s, random_stream& random) {
             return a_body<Scenario>(s.position, random, stone);
           });
    double counted = 0, drawn = 0;
    random_stream random(3);
    w.keep_sum("counted", counted);
    w.keep("drawn", drawn);
    w.keep("random", random);
    if (c.from > 0) CHECK(read_checkpoint(w, file).empty());
    CHECK(w.steps() == c.from);
    for (std::size_t k = c.from; k < c.to; ++k) {
      w.step(c.dt);
      counted += 1;
      drawn = random.uniform();
      if (w.steps() % 60 == 10 && !independent_of_ranks<Scenario>)
        (void)w.add_if_local(
            body{.shape = sphere{0.4}, .position = {drawn, 0.5, 8}, .material = stone});
      if (w.steps() == c.write_after) write_checkpoint(w, file);
    }
    const motion m = measure_motion(w);
    const std::string digest = state_digest(w);
    link.reduce(reduction::sum, std::span(&counted, 1));
    if (link.rank() == 0) end = {digest, m.bodies, m.asleep, counted, drawn};
  });
  return end;
}

template <class Scenario>
void check_restarts(std::size_t half, double dt) {
  const scratch_file file;
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    const outcome whole = run_course<Scenario>(
        {.ranks = ranks, .to = 2 * half, .write_after = half, .dt = dt}, file.name);
    CHECK(run_course<Scenario>({.ranks = ranks, .from = half, .to = 2 * half, .dt = dt},
                               file.name) == whole);
    // On another number of ranks the state is the same to the bit, but the later trajectory
    // differs.
    const int others = ranks == 1 ? 4 : ranks / 2;
    const outcome then = run_course<Scenario>({.ranks = ranks, .from = half, .to = half, .dt = dt},
                                              file.name),
                  there = run_course<Scenario>(
                      {.ranks = others, .from = half, .to = half, .dt = dt}, file.name),
                  later = run_course<Scenario>(
                      {.ranks = others, .from = half, .to = 2 * half, .dt = dt}, file.name);
    CHECK(then.digest == there.digest);
    CHECK(then.bodies == there.bodies);
    CHECK(then.asleep == there.asleep);
    if constexpr (std::is_same_v<Scenario, pile>) CHECK(then.asleep > 0);
    CHECK(later.bodies == whole.bodies);
    if constexpr (independent_of_ranks<Scenario>) CHECK(later.digest == whole.digest);
    CHECK(later.random == whole.random);
    CHECK(later.counted == static_cast<double>(half * static_cast<std::size_t>(ranks) +
                                               half * static_cast<std::size_t>(others)));
  }
}

}  // namespace talus::restarts
