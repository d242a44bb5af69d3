// Polyhedra and unions across ranks: momentum, migration, and how often their form is sent.
// long
#include <doctest/doctest.h>

#include <set>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/frame.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using dumbbell = union_of<sphere, box>;
template <class Correction>
using cloud = scenario<bodies<sphere, convex_polyhedron, dumbbell>,
                       hard_contact<coulomb_friction, newton_restitution, Correction>,
                       decomposition<grid<dynamic, dynamic>>>;
constexpr real extent = 5;

grid<dynamic, dynamic> cells() { return {.lower = {-extent, -extent}, .upper = {extent, extent}}; }

convex_polyhedron grain() {
  return convex_polyhedron({{0.5, 0, 0},
                            {-0.4, 0.3, 0},
                            {-0.3, -0.4, 0.1},
                            {0, 0, 0.6},
                            {0.1, 0.2, -0.5},
                            {0.3, -0.3, 0.4},
                            {-0.2, 0.4, 0.4}});
}
dumbbell hammer() {
  return dumbbell({{.shape = sphere{0.35}, .at = {{0, 0, -0.4}}},
                   {.shape = box{{0.5, 0.4, 0.3}}, .at = {{0.1, 0, 0.3}}, .density = 2}});
}

/// Bodies on a lattice, each layer of one kind, flying towards the centre.
template <class World>
void set_up(World& w) {
  const auto stuff = w.material({.density = 1.5, .restitution = 0.4, .friction = 0.3});
  w.seed(7);
  const convex_polyhedron stone = grain();
  const dumbbell tool = hammer();
  const auto layer = [&](real z) {
    return simple_cubic{.spacing = 1.7, .origin = {0.3, 0.2, z}} &
           box_region{{-extent, -extent, z - 0.1}, {extent, extent, z + 0.1}};
  };
  const auto one = [&](const auto& shape) {
    using shape_type = std::remove_cvref_t<decltype(shape)>;
    return [&w, &shape, stuff](const site& at, random_stream& random) {
      return body<shape_type>{
          .shape = shape,
          .position = at.position,
          .material = stuff,
          .velocity = -0.8 * at.position + random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1)),
          .angular_velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 2)),
          .orientation = random.rotation()};
    };
  };
  const sphere ball{0.45};
  w.fill(layer(-1.7), one(stone));
  w.fill(layer(0), one(tool));
  w.fill(layer(1.7), one(ball));
}

real scale_of(const motion& m) { return std::sqrt(2 * m.mass * m.kinetic_energy); }

template <class Correction>
void check_momentum(int ranks, bool angular) {
  CAPTURE(ranks);
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<cloud<Correction>> w(link, cells());
    set_up(w);
    w.synchronize();
    const motion before = measure_motion(w);
    std::uint64_t collided = 0;
    for (int k = 0; k < 250; ++k) {
      w.step(0.005);
      talus::detail::state_of(w).each_contact_list([&](const auto& list) {
        list.each([&](const auto& c, bool counts) {
          collided += counts && c.impulse().squaredNorm() > 0;
        });
      });
    }
    const motion after = measure_motion(w);
    link.reduce(reduction::sum, std::span(&collided, 1));
    if (link.rank() != 0) return;
    CHECK(after.bodies == before.bodies);
    CHECK(before.bodies > 80);
    CHECK(collided > 100);
    CHECK((after.momentum - before.momentum).norm() < 1e-13 * scale_of(before));
    if (angular)
      CHECK((after.angular_momentum - before.angular_momentum).norm() <
            1e-12 * scale_of(before) * extent);
    CHECK(after.kinetic_energy < before.kinetic_energy);
  });
}

}  // namespace

TEST_CASE("polyhedra and unions conserve momentum on 1, 2, 4 and 9 ranks") {
  for (const int ranks : {1, 2, 4, 9}) check_momentum<no_correction>(ranks, true);
  check_momentum<split_correction>(4, false);
}

namespace {

struct said {
  std::uint64_t in_motion,
      changed;        ///< bytes of a step, and of one after a change of a body
  std::size_t forms;  ///< that the rank knows
};

/// The messages of a rank with four bodies on each side of a boundary, all within reach of it.
template <class Shape>
said bytes_of_step(threads::link& link, const Shape& shape) {
  world<scenario<bodies<Shape>, decomposition<grid<2>>>> w(link,
                                                           grid<2>{.lower = {-5}, .upper = {5}});
  w.material({});
  for (const real x : {-0.7, 0.7})
    for (const real z : {0., 3., 6., 9.})
      w.add_if_local(body<Shape>{.shape = shape, .position = {x, 0, z}});
  for (int k = 0; k < 40; ++k) w.step(0.01);
  std::set<const void*> forms;
  w.for_each_known([&](const auto& b) {
    if constexpr (requires { b.shape().mesh(); }) forms.insert(&b.shape().mesh());
  });
  const auto bytes = [&] {
    const auto before = link.counters();
    w.step(0.01);
    return (link.counters() - before).bytes;
  };
  const auto in_motion = bytes();
  std::uint64_t changed = 0;
  for (int k = 0; k < 2; ++k) {  // at first the other rank must receive the form again
    w.for_each_local([](auto b) { b.set_velocity({0, 0, 0}); });
    changed = bytes();
  }
  return {in_motion, changed, forms.size()};
}

}  // namespace

TEST_CASE("the form of a body travels when it is new to a neighbour, and by its name after that") {
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    const convex_polyhedron stone = grain();
    detail::byte_buffer whole;
    detail::byte_writer(whole).put(stone);
    const said boxes = bytes_of_step(link, box{{1.2, 1, 1}});
    const said stones = bytes_of_step(link, stone);
    if (link.rank() == 0) MESSAGE(stones.changed, " bytes a step; a form takes ", whole.size());
    CHECK(stones.in_motion == boxes.in_motion);  // only poses
    CHECK(boxes.changed > boxes.in_motion);
    CHECK(stones.changed == boxes.changed + 4 * 17 - 4 * sizeof(box));
    CHECK(whole.size() > 1000);
    CHECK(boxes.forms == 0);
    CHECK(stones.forms == 1);  // received forms are shared with existing ones
  });
}

TEST_CASE("a polyhedron goes round all ranks and stays what it is") {
  threads::launch({.ranks = 4}, [&](threads::link& link) {
    using overflow = scenario<bodies<convex_polyhedron, dumbbell>, decomposition<grid<2, 2>>>;
    world<overflow> w(link, grid<2, 2>{.lower = {-5, -5}, .upper = {5, 5}});
    w.material({.density = 3});
    const convex_polyhedron stone = grain();
    const dumbbell tool = hammer();
    w.add_if_local(body<convex_polyhedron>{.shape = stone, .position = {2, 2, 0}});
    w.add_if_local(body<dumbbell>{.shape = tool, .position = {2, 2, 5}});
    std::set<int> owners;
    for (int k = 0; k < 400; ++k) {
      w.for_each_local([&](auto b) {
        const vec3 p = b.position();
        b.set_velocity(vec3(-p[1], p[0], 0));
      });
      w.step(0.05);
      std::uint64_t here = w.local_bodies(), all = here;
      link.reduce(reduction::sum, std::span(&all, 1));
      CHECK(all == 2);
      w.for_each_local([&](const auto& b) {
        if constexpr (requires { b.shape().mesh(); })
          CHECK(b.shape() == stone);
        else
          CHECK(b.shape() == tool);
        CHECK(b.mass() == doctest::Approx(3 * b.shape().volume()));
      });
      if (here > 0) owners.insert(k);
    }
    CHECK(owners.size() > 50);
  });
}

TEST_CASE("a union is global: fixed, known on all ranks, and met by what falls on it") {
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    using steps = union_of<sphere, box>;
    using scene = scenario<bodies<sphere, steps>, decomposition<grid<2>>>;
    world<scene> w(link, grid<2>{.lower = {-20}, .upper = {20}});
    w.material({.friction = 0.5});
    w.gravity({0, 0, -10});
    std::vector<steps::part> parts;
    for (int k = -10; k < 10; ++k)
      parts.push_back({.shape = box{{2, 2, 1}}, .at = {{2. * k + 1, 0, 0.1 * k}}});
    const steps stair(parts);
    const pose at = placed(stair);
    w.global([&](auto& scope) { scope.add(stair, {}, at.position, at.orientation); });
    for (const real x : {-11., -3., 5., 13.})
      w.add_if_local(body<sphere>{.shape = {0.5}, .position = {x, 0, 3}});
    for (int k = 0; k < 500; ++k) w.step(0.005);
    int seen = 0;
    w.for_each_local([&](const auto& b) {
      if constexpr (std::remove_cvref_t<decltype(b)>::shape_type::isotropic) {
        ++seen;
        const real step = 0.1 * std::floor(b.position()[0] / 2);
        CHECK(b.position()[2] == doctest::Approx(step + 1).epsilon(1e-3));
        CHECK(b.velocity().norm() < 1e-2);
      }
    });
    CHECK(seen == 2);
  });
}
