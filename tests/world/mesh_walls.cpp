// Walls of triangles in a world: bodies slide and roll over them as over a plane, bodies that fall
// into them stay inside, on one rank and on four.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/mesh.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/loads.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/tables.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "../landscape.hpp"

using namespace talus;

namespace {

using scene = scenario<bodies<sphere, box, triangle_mesh, plane>, solver<reproducible>,
                       decomposition<grid<dynamic, dynamic>>, transport<threads>>;

template <class Body>
void add_mesh(world<scene>& w, const triangle_mesh& m, Body&& more) {
  w.global([&](auto& scope) {
    const pose at = placed(m);
    scope.add(
        body<triangle_mesh>{.shape = m, .position = at.position, .orientation = at.orientation});
    more(scope);
  });
}

struct end_state {
  std::vector<vec3> position, velocity;
};
/// A sphere that rolls and a box that slides over a floor, for two seconds.
end_state course(bool of_triangles) {
  end_state end;
  threads::launch({}, [&](threads::link& link) {
    world<scene> w(link);
    w.gravity({0, 0, -10});
    w.material({.restitution = 0, .friction = 0.3});
    if (of_triangles)
      add_mesh(w, triangle_mesh(landscape(37, 30, [](real, real) { return 0; })), [](auto&) {});
    else
      w.global([&](auto& scope) { scope.add(plane{}, {}); });
    const auto ball =
        w.add(body{.shape = sphere{0.4}, .position = {-8, 0.3, 0.4}, .velocity = {4, 0.7, 0}});
    const auto crate = w.add(
        body{.shape = box{{1, 0.8, 0.6}}, .position = {-8, -3, 0.3}, .velocity = {5, 0.4, 0}});
    for (int k = 0; k < 500; ++k) w.step(1.0 / 250);
    const auto keep = [&](const auto& b) {
      end.position.push_back(b.position()), end.velocity.push_back(b.velocity());
    };
    keep(w[ball]), keep(w[crate]);
  });
  return end;
}

}  // namespace

TEST_CASE("a sphere rolls and a box slides over 2,738 triangles as over a plane") {
  const end_state on_plane = course(false), on_mesh = course(true);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK((on_plane.position[k] - on_mesh.position[k]).norm() < 1e-4);
    CHECK((on_plane.velocity[k] - on_mesh.velocity[k]).norm() < 1e-3);
  }
  CHECK(on_plane.position[0][0] > -3);
}

TEST_CASE(
    "spheres and boxes that fall into a bowl of triangles stay in it, with the same bits on 1 and "
    "4 ranks") {
  const real size = 8;
  const auto height = [](real x, real y) { return 0.15 * (x * x + y * y); };
  const triangle_mesh bowl(landscape(24, size, height));
  std::vector<std::string> digests;
  for (const int ranks : {1, 4})
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<scene> w(link, {.lower = {-4, -4}, .upper = {4, 4}});
      w.gravity({0, 0, -10});
      w.material({.restitution = 0.1, .friction = 0.4});
      w.seed(3);
      add_mesh(w, bowl, [](auto&) {});
      w.fill(simple_cubic{.spacing = 0.8} & box_region{{-1.7, -1.7, 1.2}, {1.7, 1.7, 3}},
             [](const site& at, random_stream& random) -> std::variant<body<sphere>, body<box>> {
               if (random.integer(3) == 0)
                 return body{.shape = box{{0.5, 0.4, 0.6}},
                             .position = at.position,
                             .orientation = random.rotation()};
               return body{.shape = sphere{random.uniform(0.25, 0.38)}, .position = at.position};
             });
      for (int k = 0; k < 600; ++k) w.step(1.0 / 250);
      std::size_t here = 0;
      w.for_each_local([&](const auto& b) {
        ++here;
        CHECK(b.position()[2] > height(b.position()[0], b.position()[1]));
        CHECK(std::abs(b.position()[0]) < 3);
      });
      double count = static_cast<double>(here);
      w.link().reduce(reduction::sum, std::span(&count, 1));
      const double kinetic = measure_motion(w).kinetic_energy;
      const auto digest = state_digest(w);
      if (link.rank() != 0) return;
      CHECK(count > 40);
      CHECK(kinetic < 1);
      digests.push_back(digest);
    });
  CHECK(digests[0] == digests[1]);
}

TEST_CASE("the energy ledger closes for boxes thrown against upright walls of triangles") {
  using watched = scenario<bodies<box, triangle_mesh, plane>,
                           hard_contact<coulomb_friction, newton_restitution>, transport<serial>,
                           features<energy_ledger>>;
  std::vector<triangle_mesh::triangle> walls;
  const auto corner = [](int k) { return vec3(std::cos(pi * k / 12), std::sin(pi * k / 12), 0); };
  for (int k = 0; k < 24; ++k) {
    const vec3 a = 2 * corner(k), b = 2 * corner(k + 1), up(0, 0, 3);
    walls.push_back({a, b, vec3(b + up)}), walls.push_back({a, vec3(b + up), vec3(a + up)});
  }
  const triangle_mesh vessel(walls);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    serial::link link;
    world<watched> w(link);
    w.gravity({0, 0, -9.81});
    w.material({.restitution = 0.3, .friction = 0.4});
    w.global([&](auto& scope) {
      const pose at = placed(vessel);
      scope.add(plane{}, {});
      scope.add(vessel, {}, at.position, at.orientation);
    });
    random_stream random(seed, 0);
    for (int k = 0; k < 4; ++k)
      w.add(body{.shape = box{{0.14, 0.16, 0.18}},
                 .position = {0.6 * k - 0.9, 0, 0.9},
                 .velocity = random.uniform(vec3(-60, -60, -12), vec3(60, 60, 12))});
    w.simulate({.steps = 120, .dt = 0.002});
    CHECK(measure_energy(w).worst < 1e-12);
  }
}

TEST_CASE("a mesh that should move is refused, and one that is fixed is no body that moves") {
  threads::launch({}, [&](threads::link& link) {
    world<scene> w(link);
    w.material({});
    const triangle_mesh m(landscape(1, 2, [](real, real) { return 0; }));
    CHECK_THROWS_WITH(
        w.add(body{.shape = m}),
        "a triangle_mesh has no mass, so nothing can move it, but rank 0 added one to "
        "the bodies that move: add it in world.global(...), or with .fixed = true; to make it "
        "move, "
        "build it of convex parts, as a convex_polyhedron or a union_of<convex_polyhedron>");
    const auto h = w.add(body{.shape = m, .fixed = true});
    CHECK_THROWS_WITH(w[h].release(), doctest::Contains("has no mass and stays fixed"));
    CHECK(w[h].mass() == 0);
    CHECK(w[h].inertia() == vec3(0, 0, 0));
    CHECK(measure_body(w, h).mass == 0);
    CHECK(body_table(w).numbers("mass")[0] == 0);
  });
}
