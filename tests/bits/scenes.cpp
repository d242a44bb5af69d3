// Six scenes whose digests are pinned: the same bits from every compiler, at every level of
// optimisation, for every set of instructions of x86-64, on 1 and 4 ranks. Compiled without a test
// framework, by the compilers and with the options listed in tests/CMakeLists.txt. A commit that
// changes arithmetic on purpose replaces the digests by those that this program prints.
//   scenes [PART OF A NAME [STEPS]]     only those runs, with a digest each so many steps
#include <unistd.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <talus/checkpoint.hpp>
#include <talus/mesh.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/surfaces.hpp>
#include <talus/shape/triangle_mesh.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <variant>

using namespace talus;

namespace {

constexpr real g = 9.81;
using squares = grid<dynamic, dynamic>;
using dumbbell = union_of<sphere, capsule>;

using rubble = scenario<
    bodies<sphere, box, capsule, cylinder, convex_polyhedron, dumbbell, triangle_mesh, plane>,
    hard_contact<coulomb_friction, newton_restitution>, solver<reproducible>,
    decomposition<squares>, transport<threads>, features<driven, checkpoints>>;
using gravel = scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction>,
                        solver<reproducible>, precision<mixed_precision>,
                        decomposition<periodic<grid<dynamic, dynamic>, along::x, along::y>>,
                        transport<threads>, features<driven>>;
using sand = scenario<bodies<sphere, box, plane>,
                      soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>,
                      integrator<velocity_verlet>, decomposition<squares>, transport<threads>>;

/// Five planes around the square from -half to half.
void add_tub(auto& scope, real half, material_id stuff) {
  scope.add(plane{.normal = {0, 0, 1}}, stuff);
  for (const real side : {-1.0, 1.0}) {
    scope.add(plane{.normal = {side, 0, 0}, .offset = -half}, stuff);
    scope.add(plane{.normal = {0, side, 0}, .offset = -half}, stuff);
  }
}

// Spheres that bounce, roll and come to rest.
void set_up_balls(world<rubble>& w) {
  const auto glass = w.material({.density = 2.5, .restitution = 0.6, .friction = 0.4});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) { add_tub(scope, 4, glass); });
  w.fill(simple_cubic{.spacing = 0.9, .origin = {-3.5, -3.5, 0.6}} &
             box_region{{-3.6, -3.6, 0.3}, {3.6, 3.6, 2.8}},
         [&](const site& at, random_stream& random) {
           return body{.shape = sphere{random.uniform(0.25, 0.42)},
                       .position = at.position,
                       .material = glass,
                       .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0)),
                       .angular_velocity = random.uniform(vec3(-9, -9, -9), vec3(9, 9, 9))};
         });
}

// Towers and a wall of boxes, into which others fall.
void set_up_crates(world<rubble>& w) {
  const auto wood = w.material({.density = 0.7, .restitution = 0.1, .friction = 0.5});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) { add_tub(scope, 5, wood); });
  for (int k = 0; k < 8; ++k)
    w.add_if_local(body{.shape = box{{1, 0.8, 0.6}},
                        .position = {-3, -3, 0.3 + 0.6 * k},
                        .material = wood,
                        .orientation = rotation({0, 0, 1}, 0.2 * k)});
  for (int row = 0; row < 5; ++row)
    for (int k = 0; k < 6 - row % 2; ++k)
      w.add_if_local(body{.shape = box{{0.98, 0.5, 0.5}},
                          .position = {k - 2.5 + 0.5 * (row % 2), 0, 0.25 + 0.5 * row},
                          .material = wood});
  random_stream random(11);
  for (int k = 0; k < 14; ++k)
    w.add_if_local(body{.shape = box{random.uniform(vec3(0.3, 0.3, 0.3), vec3(0.8, 0.7, 0.6))},
                        .position = {0.6 * (k - 7), 0.3 * (k % 3) - 0.2, 4 + 0.3 * k},
                        .material = wood,
                        .angular_velocity = random.uniform(vec3(-9, -9, -9), vec3(9, 9, 9)),
                        .orientation = random.rotation()});
}

// Bodies of all shapes in a tub with a cone of triangles that rotates and shakes.
void set_up_shapes(world<rubble>& w) {
  const auto stone = w.material({.density = 2.5, .restitution = 0.3, .friction = 0.5});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) {
    add_tub(scope, 4, stone);
    const triangle_mesh hill =
        cone_surface({.lower = 2, .upper = 0.3, .height = 1.1}, {.sectors = 13, .closed = true});
    const pose at = placed(hill);
    const auto turns = scope.add(hill, stone, at.position, at.orientation);
    w.drive(turns, turning{.axis = {0, 0.1, 1}, .speed = 1.3});
    const auto beats = scope.add(box{{3, 0.4, 0.4}}, stone, vec3(0, -2.5, 0.6));
    w.drive(beats, oscillation{.amplitude = {0.3, 0, 0.1}, .frequency = 1.5, .phase = 0.3});
  });
  const dumbbell pair({{sphere{0.3}, {{-0.3, 0, 0}}}, {capsule{0.12, 0.7}, {{0.2, 0, 0}}}});
  w.fill(simple_cubic{.spacing = 1.15, .origin = {-3.2, -3.2, 1.9}} &
             box_region{{-3.4, -3.4, 1.5}, {3.4, 3.4, 4.8}},
         [&](const site& at, random_stream& random)
             -> std::variant<body<sphere>, body<box>, body<capsule>, body<cylinder>,
                             body<convex_polyhedron>, body<dumbbell>> {
           const auto made = [&](const auto& shape) {
             return body{.shape = shape,
                         .position = at.position,
                         .material = stone,
                         .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0)),
                         .angular_velocity = random.uniform(vec3(-9, -9, -9), vec3(9, 9, 9)),
                         .orientation = random.rotation()};
           };
           const auto which = random.integer(6);
           const real r = random.uniform(0.25, 0.45);
           if (which == 0) return made(sphere{r});
           if (which == 1) return made(box{random.uniform(vec3(r, r, r), vec3(0.8, 0.7, 0.6))});
           if (which == 2) return made(capsule{0.6 * r, r});
           if (which == 3) return made(cylinder{r, 1.2 * r});
           if (which == 4) {
             std::vector<vec3> corners;
             for (int k = 0; k < 12; ++k) corners.push_back(1.4 * r * random.unit_vector());
             return made(convex_polyhedron(corners));
           }
           return made(pair);
         });
}

// A sheared layer that is periodic along both axes, its contacts solved in float.
void set_up_shear(world<gravel>& w) {
  const auto stone = w.material({.density = 1, .friction = 0.5});
  const auto rough = w.material({.density = 1, .friction = 2});
  w.gravity({0, 0, -g});
  handle<plane> lower, upper;
  w.global([&](auto& scope) {
    lower = scope.add(plane{.normal = {0, 0, 1}}, rough);
    upper = scope.add(plane{.normal = {0, 0, -1}, .offset = -4.5}, rough);
  });
  w.drive(lower, belt{{1, 0, 0}});
  w.hold_force(upper, {.force = 70, .max_speed = 0.5});
  w.fill(
      simple_cubic{.spacing = 1, .origin = {-3.5, -2.5, 0.5}} & box_region{{-4, -3, 0}, {4, 3, 4}},
      [&](const site& at, random_stream& random) -> std::variant<body<sphere>, body<box>> {
        const real r = random.uniform(0.38, 0.5);
        if (random.integer(2) == 0)
          return body{.shape = sphere{r}, .position = at.position, .material = stone};
        return body{.shape = box{{1.1 * r, r, 1.2 * r}},
                    .position = at.position,
                    .material = stone,
                    .orientation = random.rotation()};
      });
}

// Soft spheres and boxes that slide, roll and pile up.
void set_up_sand(world<sand>& w) {
  const auto grain = w.material({.density = 1,
                                 .restitution = 0.2,
                                 .friction = 0.5,
                                 .dynamic_friction = 0.4,
                                 .youngs_modulus = 1e5,
                                 .rolling_friction = 0.05});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) { add_tub(scope, 3.5, grain); });
  w.fill(simple_cubic{.spacing = 1, .origin = {-2.8, -2.8, 0.6}} &
             box_region{{-3.2, -3.2, 0.3}, {3.2, 3.2, 2}},
         [&](const site& at, random_stream& random) -> std::variant<body<sphere>, body<box>> {
           const vec3 push = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 0));
           if (random.integer(3) == 0)
             return body{.shape = box{random.uniform(vec3(0.4, 0.4, 0.4), vec3(0.6, 0.6, 0.6))},
                         .position = at.position,
                         .material = grain,
                         .velocity = push,
                         .orientation = random.rotation()};
           return body{.shape = sphere{random.uniform(0.3, 0.45)},
                       .position = at.position,
                       .material = grain,
                       .velocity = push};
         });
}

/// A run on 1 or 4 ranks.
struct course {
  int ranks, steps;
  real dt;
  std::string save = "", load = "";  ///< a checkpoint written halfway through, or restarted from
};

int interval = 0;  ///< steps between printed digests; 0: none

/// The digest at the end of a run that `set_up` begins, in a square from -half to half.
template <class Scenario>
std::string digest_of(const course& how, real half, void (*set_up)(world<Scenario>&)) {
  std::string digest;
  threads::launch({.ranks = how.ranks}, [&](threads::link& link) {
    const int cells = how.ranks == 1 ? 1 : 2;
    world<Scenario> w = [&] {
      if constexpr (std::is_same_v<Scenario, gravel>)
        return world<Scenario>(
            link, {{.cells = {cells, cells, 1}, .lower = {-4, -3}, .upper = {4, 3}}}, reach{1.2});
      else
        return world<Scenario>(
            link, {.cells = {cells, cells}, .lower = {-half, -half}, .upper = {half, half}});
    }();
    w.seed(7);
    set_up(w);
    if constexpr (std::is_same_v<Scenario, rubble>)
      if (!how.load.empty()) (void)read_checkpoint(w, how.load);
    while (w.steps() < static_cast<std::uint64_t>(how.steps)) {
      w.step(how.dt);
      if constexpr (std::is_same_v<Scenario, rubble>)
        if (!how.save.empty() && w.steps() == static_cast<std::uint64_t>(how.steps / 2))
          write_checkpoint(w, how.save);
      if (interval > 0 && w.steps() % static_cast<std::uint64_t>(interval) == 0) {
        const std::string now = state_digest(w);
        if (link.rank() == 0)
          std::printf("  step %llu %s\n", static_cast<unsigned long long>(w.steps()), now.c_str());
      }
    }
    const std::string last = state_digest(w);
    if (link.rank() == 0) digest = last;
  });
  return digest;
}

int differences = 0;
std::string_view only;  ///< runs whose names contain this

template <class Run>
void compare(const char* name, std::string_view pinned, Run&& run) {
  if (!only.empty() && std::string_view(name).find(only) == std::string_view::npos) return;
  const std::string found = run();
  std::printf("%-28s %s%s\n", name, found.c_str(), found == pinned ? "" : "  differs");
  differences += found != pinned;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) only = argv[1];
  if (argc > 2) interval = std::atoi(argv[2]);
  const std::string file = "/tmp/talus_bits_" + std::to_string(getpid()) + ".h5";
  const real dt = 1.0 / 240;
  const auto balls = [&](int ranks) {
    return digest_of<rubble>({ranks, 800, dt}, 4, set_up_balls);
  };
  const auto crates = [&](int ranks) {
    return digest_of<rubble>({ranks, 700, dt}, 5, set_up_crates);
  };
  const auto shear = [&](int ranks) {
    return digest_of<gravel>({ranks, 600, dt}, 4, set_up_shear);
  };
  const auto soft = [&](int ranks) {
    return digest_of<sand>({ranks, 2000, dt / 8}, 3.5, set_up_sand);
  };
  compare("balls, 1 rank", "b92e9bbe34f58af7", [&] { return balls(1); });
  compare("balls, 4 ranks", "b92e9bbe34f58af7", [&] { return balls(4); });
  compare("crates, 1 rank", "cbb81dd6bfffa0f9", [&] { return crates(1); });
  compare("crates, 4 ranks", "cbb81dd6bfffa0f9", [&] { return crates(4); });
  compare("shapes, 1 rank", "a0226a72cd208bb2", [&] {
    return digest_of<rubble>({1, 700, dt}, 4, set_up_shapes);
  });
  compare("shapes, 4 ranks", "a0226a72cd208bb2", [&] {
    return digest_of<rubble>({4, 700, dt, file}, 4, set_up_shapes);
  });
  compare("shapes, restarted on 1 rank", "a0226a72cd208bb2", [&] {
    return digest_of<rubble>({1, 700, dt, "", file}, 4, set_up_shapes);
  });
  compare("shear, 1 rank", "6d4a30697ac99f47", [&] { return shear(1); });
  compare("shear, 4 ranks", "6d4a30697ac99f47", [&] { return shear(4); });
  compare("sand, 1 rank", "1a04ef36c523b289", [&] { return soft(1); });
  compare("sand, 4 ranks", "1a04ef36c523b289", [&] { return soft(4); });
  unlink(file.c_str());
  if (differences > 0)
    std::printf("%d digests differ from those pinned in scenes.cpp\n", differences);
  return differences > 0;
}
