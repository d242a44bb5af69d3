// Worlds on every kind of domain: bodies cross its faces and are conserved, and crossing a closed
// face ends the run.
#include <doctest/doctest.h>

#include <talus/observe/motion.hpp>
#include <talus/parallel/cells.hpp>
#include <talus/parallel/hexagonal.hpp>
#include <talus/parallel/join.hpp>
#include <talus/parallel/rectilinear.hpp>
#include <talus/parallel/ring.hpp>
#include <talus/parallel/slabs.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

template <class Decomposition>
using cloud_of = scenario<bodies<sphere>, transport<threads>,
                          hard_contact<coulomb_friction, newton_restitution, no_correction>,
                          decomposition<Decomposition>>;

/// Spheres between two radii about the z axis, each with a velocity that depends on its position.
template <class World, class Velocity>
void fill_ring(World& w, real inner, real outer, Velocity&& velocity) {
  const auto stuff = w.material({.density = 1.5, .restitution = 0.4, .friction = 0.3});
  w.seed(7);
  const auto sites =
      simple_cubic{.spacing = 1.3} & box_region{{-outer, -outer, -2}, {outer, outer, 2}};
  w.fill(sites, [&](const site& s, random_stream& random) -> std::optional<body<sphere>> {
    const real radius = random.uniform(0.3, 0.6);
    const vec3 v = velocity(s.position) + random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
    const vec3 spin = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 2));
    const real out = std::hypot(s.position[0], s.position[1]);
    if (out < inner || out > outer) return std::nullopt;
    return body<sphere>{.shape = sphere{radius},
                        .position = s.position,
                        .material = stuff,
                        .velocity = v,
                        .angular_velocity = spin};
  });
}

/// Runs a cloud on as many ranks as the decomposition has, and checks conservation. Returns how
/// many bodies changed their rank, and how many contacts carried an impulse.
struct outcome {
  std::uint64_t moved = 0, collided = 0, messages = 0;
};
template <class Decomposition, class Velocity>
outcome conserve(const Decomposition& d, real inner, real outer, int steps, Velocity&& velocity) {
  outcome all;
  threads::launch({.ranks = d.size()}, [&](threads::link& link) {
    world<cloud_of<Decomposition>> w(link, d);
    CHECK_NOTHROW(w.check_connections());
    fill_ring(w, inner, outer, velocity);
    w.synchronize();
    std::vector<system_id> mine;
    w.for_each_local([&](const auto& b) { mine.push_back(b.id()); });
    std::sort(mine.begin(), mine.end());
    const motion before = measure_motion(w);
    std::uint64_t counts[2] = {0, 0};
    for (int k = 0; k < steps; ++k) {
      w.step(0.005);
      talus::detail::state_of(w).each_contact_list([&](const auto& list) {
        list.each([&](const auto& c, bool counts_here) {
          counts[0] += counts_here && c.impulse().squaredNorm() > 0;
        });
      });
    }
    w.for_each_local(
        [&](const auto& b) { counts[1] += !std::binary_search(mine.begin(), mine.end(), b.id()); });
    const motion after = measure_motion(w);
    link.reduce(reduction::sum, std::span(counts));
    std::uint64_t messages = w.step_messages().messages_max;
    link.reduce(reduction::max, std::span(&messages, 1));
    if (link.rank() != 0) return;
    all = {counts[1], counts[0], messages};
    const real scale = std::sqrt(2 * before.mass * before.kinetic_energy);
    CHECK(before.bodies > 100);
    CHECK(after.bodies == before.bodies);
    CHECK((after.momentum - before.momentum).norm() < 1e-13 * scale);
    CHECK((after.angular_momentum - before.angular_momentum).norm() < 1e-12 * scale * outer);
    CHECK(after.kinetic_energy < before.kinetic_energy);
  });
  return all;
}

const auto inwards = [](const vec3& p) { return vec3(-p); };
const auto around = [](const vec3& p) { return vec3(-p[1], p[0], 0); };

}  // namespace

TEST_CASE("a cloud of spheres crosses hexagonal domains and keeps its momentum to round-off") {
  const auto [moved, collided, messages] = conserve(hexagonal<1>{.spacing = 4}, 0, 7, 300, inwards);
  CHECK(moved > 50);
  CHECK(collided > 100);
}

TEST_CASE("a cloud of spheres goes around in a ring of domains and keeps its momentum") {
  const auto [moved, collided, messages] = conserve(ring<6>{.hub = 4}, 5, 9, 300, around);
  CHECK(moved > 50);
  CHECK(collided > 50);
}

TEST_CASE("a cloud of spheres crosses the user's own cells, one in the form of an L") {
  const auto quarter = intersect(half_space(1, 0, 0, 1), half_space(0, 1, 0, 0.5));
  const auto [moved, collided, messages] =
      conserve(cells(complement(quarter), quarter), 0, 7, 300, inwards);
  CHECK(moved > 15);
  CHECK(collided > 100);
}

TEST_CASE("a cloud of spheres crosses domains side by side") {
  const auto [moved, collided, messages] =
      conserve(join(slabs<3>{.lower = -3, .upper = 3},
                    within(half_space(0.3, 1, 0.2, 2), ring<3>{.centre = {1, 2.5, 0}})),
               0, 7, 300, inwards);
  CHECK(moved > 50);
  CHECK(collided > 100);
}

TEST_CASE("messages depend on the neighbours of a rank, not on the number of ranks") {
  const auto messages_of = [](auto d, std::size_t most_neighbours) {
    std::uint64_t most = 0;
    threads::launch({.ranks = d.size()}, [&](threads::link& link) {
      world<cloud_of<decltype(d)>> w(link, d);
      CHECK(w.connections().size() <= most_neighbours);
      (void)w.material({});
      w.step(0.01);
      if (link.rank() == 0) most = w.step_messages().messages_max;
    });
    return most;
  };
  const auto two = messages_of(ring<4>{}, 2);
  CHECK(two > 0);
  CHECK(messages_of(ring<12>{}, 2) == two);
  CHECK(messages_of(hexagonal<1>{.spacing = 2}, 6) == 3 * two);
  CHECK(messages_of(hexagonal<3>{.spacing = 2}, 6) == 3 * two);
}

TEST_CASE("a body whose bounds reach a closed face ends the run with its place, ranks and face") {
  using scene = scenario<bodies<sphere, box>, transport<threads>, decomposition<ring<6>>>;
  const ring<6> d{.angle = pi, .closed = true};  // open above, closed in the middle below
  const auto run = [&](const auto& what, vec3 velocity, int steps) {
    threads::launch({.ranks = 6}, [&](threads::link& link) {
      world<scene> w(link, d);
      const auto stuff = w.material({});
      auto b = what;
      b.material = stuff;
      b.velocity = velocity;
      w.add_if_local(b);
      for (int k = 0; k < steps; ++k) w.step(0.01);
      std::uint64_t bodies = w.local_bodies();
      link.reduce(reduction::sum, std::span(&bodies, 1));
      CHECK(bodies == 1);
    });
  };
  const auto refuses = [&](const auto& what, vec3 velocity, int steps,
                           std::vector<const char*> texts) {
    for (const char* text : texts)
      CHECK_THROWS_WITH_AS(run(what, velocity, steps), doctest::Contains(text), std::runtime_error);
  };
  const body<sphere> ball{.shape = sphere{0.5}, .position = {2, -5, 0}};
  const body<box> plank{.shape = box{.size = {0.2, 3, 0.2}}, .position = {0.8, -5, 0}};

  run(ball, {0, 0, 0}, 3);
  run(plank, {0, 0, 0}, 3);    // its bounding ball reaches there, the plank does not
  run(ball, {0, 10, 0}, 100);  // through the connected faces, past sector 0's start
  refuses(ball, {-5, 0, 0}, 100,
          {"(sphere)", "reaches a closed face in step 3", "rank 0 owns the body",
           "not connected to rank 5", "x"});
  refuses(ball, {-400, 0, 0}, 100, {"rank 0 owns the body", "not connected to rank 5"});
  refuses(body<box>{.shape = box{.size = {3, 0.2, 0.2}}, .position = {0.8, -5, 0}}, {0, 0, 0}, 1,
          {"(box)", "reaches a closed face in step 0", "rank 5"});
  // The hub: where all sectors meet.
  refuses(body<sphere>{.shape = sphere{0.5}, .position = {3, 0.5, 0}}, {-2, 0, 0}, 200,
          {"(0.5, 0.5, 0) reaches a closed face", "rank 1 owns the body",
           "not connected to rank 3, which begins at (0, 0.5, 0)"});
}

TEST_CASE("reach connects the ranks of a world beyond those that touch") {
  using scene = scenario<bodies<sphere>, transport<threads>, decomposition<slabs<dynamic>>>;
  threads::launch({.ranks = 5}, [&](threads::link& link) {
    const slabs<dynamic> d{.lower = 0, .upper = 10};
    world<scene> w(link, d, reach{2});
    CHECK(w.connections().size() == (link.rank() == 2 ? 4 : link.rank() % 4 == 0 ? 2 : 3));
    w.decompose(d);
    CHECK(w.connections().size() == (link.rank() % 4 == 0 ? 1 : 2));
    w.decompose(d, reach{10});
    CHECK(w.connections().size() == 4);
    CHECK_NOTHROW(w.check_connections());
  });
}

TEST_CASE("decompose() gives a world its numbers, and one rank takes all of space") {
  const auto try_out = [](const auto& d, int ranks) {
    using decomposition_type = std::remove_cvref_t<decltype(d)>;
    for (const int n : {1, ranks})
      threads::launch({.ranks = n}, [&](threads::link& link) {
        world<cloud_of<decomposition_type>> w(link);
        w.decompose(d);
        const auto stuff = w.material({});
        w.add_if_local(
            body<sphere>{.shape = sphere{0.1}, .position = {5, 5, 5}, .material = stuff});
        w.step(0.01);
        std::uint64_t bodies = w.local_bodies();
        link.reduce(reduction::sum, std::span(&bodies, 1));
        CHECK(bodies == 1);
      });
  };
  const half_space below(0, 0, -1, 0);
  try_out(hexagonal<1>{.spacing = 3}, 7);
  try_out(hexagonal<dynamic>{.spacing = 3}, 7);
  try_out(ring<3>{}, 3);
  try_out(ring<dynamic>{}, 3);
  try_out(slabs<3>{.lower = 0, .upper = 1}, 3);
  try_out(slabs<dynamic>{.cuts = {1, 2}}, 3);
  try_out(rectilinear<2, 2>{.x = {0}, .y = {1}}, 4);
  try_out(rectilinear<>{.x = {0}, .z = {1, 2}}, 6);
  try_out(cells(below, complement(below)), 2);
  try_out(cells(std::vector<any_geometry>{below, complement(below)}), 2);
  try_out(join(ring<3>{}, within(below, slabs<1>{})), 4);
  try_out(join(ring<3>{}, within(below, slabs<dynamic>{})), 4);
}

TEST_CASE("fill visits the sites near a rank's own region only") {
  using scene = scenario<bodies<sphere>, transport<threads>, decomposition<hexagonal<2>>>;
  threads::launch({.ranks = 19}, [&](threads::link& link) {
    world<scene> w(link, {.spacing = 10});
    const auto stuff = w.material({});
    std::uint64_t made = w.fill(
        simple_cubic{.spacing = 1} & box_region{{-20, -20, 0}, {20, 20, 0}}, [&](const site& s) {
          return body<sphere>{.shape = sphere{0.1}, .position = s.position, .material = stuff};
        });
    if (link.rank() == 0) {
      const auto [lower, upper] = talus::detail::state_of(w).own.bounds();
      CHECK(upper[0] == doctest::Approx(5));
      CHECK(lower[1] == doctest::Approx(-10 / std::sqrt(3)));
    }
    link.reduce(reduction::sum, std::span(&made, 1));
    CHECK(made == 41 * 41);
  });
}
