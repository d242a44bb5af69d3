// timeout: 300
// Passing is not touching: surfaces that do not meet within a step exert nothing on each other,
// whatever the gap along the normal between them at its start.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <talus/core/random.hpp>
#include <talus/mesh.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/frame.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/nonlinear_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

template <class... More>
using scene = scenario<bodies<sphere, box, capsule, cylinder, triangle_mesh, plane>,
                       transport<serial>, More...>;

enum class obstacle { box_edge, triangle, capsule_side, cylinder_rim, fixed_sphere, free_sphere };
constexpr obstacle all_obstacles[] = {obstacle::box_edge,     obstacle::triangle,
                                      obstacle::capsule_side, obstacle::cylinder_rim,
                                      obstacle::fixed_sphere, obstacle::free_sphere};

struct fall {
  real radius = 0.5, dt = 1.0 / 60;
  real beside = 1.04;  ///< of the centre from the plane that the obstacle touches, in radii
  real phase = 0;      ///< of the steps, in steps
  real restitution = 0.5;
  quat turn{1, 0, 0, 0};
  real gravity = 9.81;
};

/// All obstacles touch the plane x = 0 in the origin from below, and their edges run along y.
template <class World>
void put_obstacle(World& w, obstacle what, const fall& f) {
  const real r = f.radius;
  const quat q = f.turn;
  const auto at = [&](const vec3& p) { return rotated(q, vec3(r * p)); };
  const quat along_y = q * rotation({1, 0, 0}, pi / 2);
  if (what == obstacle::free_sphere)
    w.add(body<sphere>{.shape = sphere{1.5 * r}, .position = at({-1.5, 0, 0})});
  w.global([&](auto& s) {
    if (what == obstacle::box_edge)
      s.add(body<box>{
          .shape = box{{4 * r, 6 * r, 4 * r}}, .position = at({-2, 0, -2}), .orientation = q});
    if (what == obstacle::triangle) {
      const triangle_mesh m(
          std::vector<triangle_mesh::triangle>{{at({0, -6, 0}), at({0, 6, 0}), at({-6, 0, 0})}});
      const pose p = placed(m);
      s.add(body<triangle_mesh>{.shape = m, .position = p.position, .orientation = p.orientation});
    }
    if (what == obstacle::capsule_side)
      s.add(body<capsule>{
          .shape = capsule{r, 6 * r}, .position = at({-1, 0, 0}), .orientation = along_y});
    if (what == obstacle::cylinder_rim)
      s.add(body<cylinder>{
          .shape = cylinder{2 * r, 3 * r}, .position = at({-2, 0, -1.5}), .orientation = q});
    if (what == obstacle::fixed_sphere)
      s.add(body<sphere>{.shape = sphere{1.5 * r}, .position = at({-1.5, 0, 0})});
  });
}

struct end {
  vec3 velocity{0, 0, 0};  ///< in the frame of the obstacle
  real expected = 0;       ///< downwards, in free fall
  real beside = 0;         ///< the smallest x of the centre below the obstacle's level, in radii
};
/// A ball falls past an obstacle by 0.74 radii a step.
template <class Scenario>
end run(obstacle what, const fall& f, int steps = 12) {
  serial::link link;
  world<Scenario> w{link};
  w.material({.density = 1, .restitution = f.restitution, .friction = 0.3});
  const vec3 down = rotated(f.turn, vec3(0, 0, -1));
  w.gravity(f.gravity * down);
  put_obstacle(w, what, f);
  const real speed = 0.74 * f.radius / f.dt;
  const auto ball = w.add(
      body<sphere>{.shape = sphere{f.radius},
                   .position = rotated(f.turn, f.radius * vec3(f.beside, 0, 3 + 0.74 * f.phase)),
                   .velocity = speed * down});
  for (int k = 0; k < steps; ++k) w.step(f.dt);
  return {rotated(f.turn.conjugate(), w[ball].velocity()), speed + steps * f.gravity * f.dt, 0};
}

const quat turns[] = {quat(1, 0, 0, 0), rotation({1, 2, 3}, 1.1), rotation({-2, 1, 0.3}, 2.3)};

template <class... More>
void check_free_fall() {
  real most = 0;
  for (const obstacle what : all_obstacles)
    for (const real e : {0., 0.5})
      for (const real dt : {1.0 / 60, 1.0 / 1000})
        for (const real radius : {0.01, 0.5, 20.})
          for (int n = 0; n < 16; ++n) {
            const fall f{.radius = radius,
                         .dt = dt,
                         .beside = n < 8 ? 1.04 : 1.004,
                         .phase = n % 8 / 8.,
                         .restitution = e,
                         .turn = turns[n % 3],
                         // By far less than a radius in these steps.
                         .gravity = 0.01 * radius / (dt * dt)};
            const end x = run<scene<More...>>(what, f);
            const real off = std::max(std::hypot(x.velocity[0], x.velocity[1]),
                                      std::abs(x.velocity[2] + x.expected)) /
                             x.expected;
            INFO("obstacle ", static_cast<int>(what), ", radius ", radius, ", dt ", dt,
                 ", restitution ", e, ", phase ", n);
            CHECK(off < 1e-9);
            most = std::max(most, off);
          }
  MESSAGE("velocity off by ", most, " of the speed");
}

}  // namespace

TEST_CASE("a ball that falls beside an edge falls freely") { check_free_fall<>(); }
TEST_CASE("a body that falls spinning beside a wall falls freely, however near its corners come") {
  random_stream random(5, 1);
  int tried = 0;
  while (tried < 400) {
    const real r = 0.05, length = r * random.uniform(0.3, 4), dt = random.uniform(1e-4, 1. / 60);
    const quat turn = random.rotation();
    const real along = std::exp(random.uniform(-7, 0)), gap = std::exp(random.uniform(-8, -2));
    const auto fall = [&](const auto& shape) {
      const real size = shape.bounding_radius(), speed = along * r / dt;
      const int steps = std::min(2000, static_cast<int>(5 * size / (speed * dt)) + 2);
      if ((speed + 9.81 * steps * dt) * dt > 0.15 * r) return;  // a small part of the inner radius
      ++tried;
      serial::link link;
      world<scene<>> w(link);
      w.gravity({0, 0, -9.81});
      w.material({.density = 1000, .restitution = random.uniform(0, 1), .friction = 0.5});
      w.global([](auto& s) { s.add(body{.shape = box{{2, 2, 0.4}}, .position = {-1, 0, -0.2}}); });
      const vec3 spin = std::exp(random.uniform(-7, -1.2)) / dt * random.unit_vector();
      const auto h =
          w.add(body{.shape = shape,
                     .position = {(1 + gap) * size, 0, (1 + random.uniform(0, 1)) * size},
                     .velocity = {0, 0, -speed},
                     .angular_velocity = spin,
                     .orientation = turn});
      for (int k = 0; k < steps; ++k) w.step(dt);
      const real expected = speed + 9.81 * steps * dt;
      INFO("shape of radius ", size, ", dt ", dt, ", gap ", gap, ", angle a step ",
           dt * spin.norm());
      CHECK((vec3(w[h].velocity()) + vec3(0, 0, expected)).norm() < 1e-9 * expected);
    };
    fall(box{{r, 2 * r, length}}), fall(capsule{r, length}), fall(cylinder{r, length});
  }
}
TEST_CASE("a ball passes an edge in a step in which gravity alone closes the gap to it") {
  const real dt = 1.0 / 240, radius = 0.05;
  for (const real gap : {2e-4, 4e-4, 8e-4})
    for (const real e : {0., 0.5, 0.9})
      for (const real height : {0.0043, 0.00446, 0.0046}) {
        serial::link link;
        world<scene<>> w(link);
        w.gravity({0, 0, -9.81});
        w.material({.restitution = e, .friction = 0.5});
        w.global([](auto& s) {
          s.add(body{.shape = box{{2, 2, 0.4}}, .position = {-1, 0, -0.2}});
        });
        const auto h = w.add(body{.shape = sphere{radius},
                                  .position = {radius + gap, 0, height},
                                  .velocity = {0, 0, -height / dt}});
        w.step(dt);
        INFO("gap ", gap, ", restitution ", e, ", height ", height);
        CHECK((w[h].velocity() + vec3(0, 0, height / dt + 9.81 * dt)).norm() < 1e-9);
      }
}
TEST_CASE("so it does with the reproducible solver") { check_free_fall<solver<reproducible>>(); }
TEST_CASE("so it does with sleeping") { check_free_fall<features<sleeping>>(); }

namespace {

/// A ball of radius 0.5 that flies past a box about the origin at 0.01 to 0.1 radii.
struct flight {
  vec3 edges, from, way;  ///< the way in a step
  quat turn;              ///< of all
  int steps;
};
flight random_flight(random_stream& random, real thinnest) {
  constexpr real radius = 0.5;
  for (;;) {
    const vec3 edges = random.uniform(vec3(thinnest, 0.5, 0.5), vec3(thinnest + 0.5, 3, 3));
    const vec3 way = random.uniform(0.1, 1.5) * radius * random.unit_vector();
    const int steps = static_cast<int>(6 / way.norm()) + 2;
    const vec3 side = way.cross(random.unit_vector()).normalized();
    const vec3 from = random.uniform(0.5, 3) * side - (0.5 * steps + random.uniform()) * way;
    const auto distance = [&](real step) {  // of the surfaces
      const vec3 at = from + step * way;
      const vec3 out = (at.cwiseAbs() - 0.5 * edges).cwiseMax(vec3(0, 0, 0));
      return out.norm() - radius;
    };
    real nearest = 1;
    for (int k = 0; k <= 50 * steps; ++k) nearest = std::min(nearest, distance(k / 50.));
    if (nearest > 0.01 * radius && nearest < 0.1 * radius)
      return {edges, from, way, random.rotation(), steps};
  }
}

}  // namespace

TEST_CASE_TEMPLATE("a ball that flies past a box or a thin plate keeps its velocity", Scene,
                   scene<>, scene<solver<reproducible>>) {
  constexpr std::uint64_t seed = 3;
  random_stream random(seed, 1);
  CAPTURE(seed);
  const real dt = 1.0 / 60;
  for (int flights = 0; flights < 200; ++flights) {
    const flight f = random_flight(random, flights % 4 < 2 ? 0.02 : 0.5);
    serial::link link;
    world<Scene> w{link};
    w.material({.density = 1, .restitution = 0.5, .friction = 0.3});
    w.add(body<box>{.shape = box{f.edges}, .orientation = f.turn, .fixed = flights % 2 == 0});
    const vec3 v = f.turn * f.way / dt;
    const auto ball =
        w.add(body<sphere>{.shape = sphere{0.5}, .position = f.turn * f.from, .velocity = v});
    for (int k = 0; k < f.steps; ++k) w.step(dt);
    CAPTURE(flights);
    CHECK((w[ball].velocity() - v).norm() < 1e-9 * v.norm());
  }
}

TEST_CASE_TEMPLATE("balls that fly past boxes keep their velocities on 2 and 4 ranks", Solver,
                   solver<nonlinear_gauss_seidel>, solver<reproducible>) {
  using pairs =
      scenario<bodies<sphere, box>, decomposition<grid<dynamic>>, transport<threads>, Solver>;
  for (const std::vector<int>& cells : {std::vector{2, 1}, std::vector{2, 2}}) {
    threads::launch({.ranks = cells[0] * cells[1]}, [&](threads::link& link) {
      world<pairs> w(
          link, grid<dynamic>{
                    .cells = {cells[0], cells[1]}, .lower = {-100, -2000}, .upper = {100, 2000}});
      w.material({.density = 1, .restitution = 0.5, .friction = 0.3});
      random_stream random(4, 1);
      const real dt = 1.0 / 60;
      std::vector<vec3> expected;
      int most = 0;
      for (int n = 0; n < 40; ++n) {  // with cuts through the obstacles at x = 0, and one at y = 0
        flight f;
        do f = random_flight(random, n % 4 < 2 ? 0.02 : 0.5);
        while (f.steps > 40);  // no ball comes to the place of another one
        const vec3 at{0, 90. * (n - 20), 0};
        w.add_if_local(body<box>{
            .shape = box{f.edges}, .position = at, .orientation = f.turn, .fixed = n % 2 == 0});
        expected.push_back(f.turn * f.way / dt);
        w.add_if_local(body<sphere>{
            .shape = sphere{0.5}, .position = at + f.turn * f.from, .velocity = expected.back()});
        most = std::max(most, f.steps);
      }
      for (int k = 0; k < most; ++k) w.step(dt);
      w.for_each_local([&](const auto& b) {
        if (b.velocity() == vec3(0, 0, 0)) return;
        const auto n = static_cast<std::size_t>(std::lround(b.position()[1] / 90) + 20);
        const vec3& v = expected[n];
        CHECK((b.velocity() - v).norm() < 1e-9 * v.norm());
      });
    });
  }
}

TEST_CASE_TEMPLATE("a ball that flies past another one keeps its velocity", Scene, scene<>,
                   scene<solver<reproducible>>) {
  constexpr std::uint64_t seed = 5;
  random_stream random(seed, 1);
  CAPTURE(seed);
  const real dt = 1.0 / 60, radius = 0.5;
  for (int n = 0; n < 300; ++n) {
    const real other = random.uniform(0.1, 1);
    const vec3 way = random.uniform(0.02, 1.5) * std::min(radius, other) * random.unit_vector();
    const int steps = static_cast<int>(6 / way.norm()) + 2;
    const vec3 side = way.cross(random.unit_vector()).normalized();
    const real nearest = std::pow(10., random.uniform(-3, -1)) * std::min(radius, other);
    const vec3 from = (radius + other + nearest) * side - (0.5 * steps + random.uniform()) * way;
    const vec3 common = n % 2 == 0 ? vec3(0, 0, 0) : vec3(-0.5 * way / dt);
    serial::link link;
    world<Scene> w{link};
    w.material({.density = 1, .restitution = 0.5, .friction = 0.3});
    w.add(body<sphere>{.shape = sphere{other}, .velocity = common});
    const auto ball = w.add(
        body<sphere>{.shape = sphere{radius}, .position = from, .velocity = way / dt + common});
    for (int k = 0; k < steps; ++k) w.step(dt);
    CAPTURE(n);
    CHECK((w[ball].velocity() - common - way / dt).norm() < 1e-9 * way.norm() / dt);
  }
}

TEST_CASE("a ball that falls upon an edge is turned aside, and does not enter the obstacle") {
  for (const obstacle what : all_obstacles)
    for (const real e : {0., 0.5})
      for (int n = 0; n < 8; ++n) {
        const fall f{
            .beside = 0.9, .phase = n / 8., .restitution = e, .turn = turns[n % 3], .gravity = 0};
        const end x = run<scene<>>(what, f);
        INFO("obstacle ", static_cast<int>(what), ", restitution ", e, ", phase ", n);
        CHECK(x.velocity[0] > 0.01 * x.expected);
      }
}

TEST_CASE("a pair of balls that pass each other keep their velocities, on one rank and on two") {
  using pairs = scenario<bodies<sphere>, decomposition<grid<dynamic>>, transport<threads>>;
  using exact = scenario<bodies<sphere>, solver<reproducible>, decomposition<grid<dynamic>>,
                         transport<threads>>;
  const auto check = []<class Scenario>(std::type_identity<Scenario>, int ranks) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<Scenario> w(link, grid<dynamic>{.cells = {ranks}, .lower = {-8}, .upper = {8}});
      w.material({.restitution = 0.5, .friction = 0.3});
      const real dt = 0.01, speed = 37;
      for (int n = 0; n < 10; ++n) {
        const real y = 10 * n, ahead = 0.074 * n;
        w.add_if_local(body{
            .shape = sphere{0.5}, .position = {-2 - ahead, y, 0.52}, .velocity = {speed, 0, 0}});
        w.add_if_local(
            body{.shape = sphere{0.5}, .position = {2, y, -0.52}, .velocity = {-speed, 0, 0}});
      }
      for (int k = 0; k < 12; ++k) w.step(dt);
      w.for_each_local([&](const auto& b) {
        const vec3 v = b.velocity();
        CHECK((vec3(std::abs(v[0]), v[1], v[2]) - vec3(speed, 0, 0)).norm() < 1e-9);
      });
    });
  };
  for (const int ranks : {1, 2}) {
    check(std::type_identity<pairs>{}, ranks);
    check(std::type_identity<exact>{}, ranks);
  }
}

TEST_CASE("a ball whose path past an edge is blocked does not enter the obstacle") {
  // A floor that ends at x = 0, where a wall begins: the free path leads past the floor's end.
  for (const bool driven_by_gravity : {false, true})
    for (const vec3& velocity : {vec3(20, 0, -10), vec3(20, 0, -30), vec3(40, 0, -60)})
      for (const real x : {-0.06, -0.1, -0.2})
        for (const real height : {0.06, 0.1, 0.16, 0.3}) {
          serial::link link;
          world<scene<>> w{link};
          w.material({.density = 1, .restitution = 0, .friction = 0});
          if (driven_by_gravity) w.gravity({0, 0, -9.81});
          w.global([](auto& s) {
            s.add(body<box>{.shape = box{{2, 2, 0.2}}, .position = {-1, 0, -0.1}});
            s.add(body<box>{.shape = box{{2, 2, 4}}, .position = {1, 0, 0}});
          });
          const auto ball = w.add(body<sphere>{
              .shape = sphere{0.05}, .position = {x, 0, height}, .velocity = velocity});
          CAPTURE(velocity[2]);
          CAPTURE(x);
          CAPTURE(height);
          for (int k = 0; k < 30; ++k) {
            w.step(1.0 / 60);
            CHECK(w[ball].position()[2] >= -1e-9);
            CHECK(w[ball].position()[0] <= 1e-9);
          }
          CHECK(w[ball].position()[2] > 0.049);
        }
}

TEST_CASE("a passing ball that another one strikes in that step does not enter the obstacle") {
  real deepest = 0;
  for (const obstacle what : {obstacle::box_edge, obstacle::triangle, obstacle::capsule_side})
    for (int n = 0; n < 8; ++n)
      for (int struck = 2; struck < 7; ++struck) {
        serial::link link;
        world<scene<>> w{link};
        w.material({.density = 1, .restitution = 0.5, .friction = 0});
        const fall f{.phase = n / 8.};
        put_obstacle(w, what, f);
        const real r = f.radius, speed = 0.74 * r / f.dt, height = (3 + 0.74 * f.phase) * r;
        const auto ball = w.add(body<sphere>{
            .shape = sphere{r}, .position = {1.04 * r, 0, height}, .velocity = {0, 0, -speed}});
        // It strikes the ball in that step, and drives it by 0.33 radii a step.
        w.add(body<sphere>{.shape = sphere{r},
                           .position = {(3.04 + 0.444 * (struck - 0.5)) * r, 0, height},
                           .velocity = {-0.6 * speed, 0, -speed}});
        real most = 0;
        for (int k = 0; k < 12; ++k) {
          w.step(f.dt);
          const vec3 p = w[ball].position() / r;
          const vec3 nearest = what == obstacle::capsule_side ? vec3(-1, 0, 0)
                               : what == obstacle::triangle
                                   ? vec3(std::min(p[0], real(0)), 0, 0)
                                   : vec3(std::min(p[0], real(0)), 0, std::min(p[2], real(0)));
          const real reach = what == obstacle::capsule_side ? 2 : 1;
          if (std::abs(p[2]) < 3.5) most = std::max(most, reach - (p - nearest).norm());
        }
        INFO("obstacle ", static_cast<int>(what), ", phase ", n, ", struck in step ", struck);
        CHECK(most < 0.35);
        deepest = std::max(deepest, most);
      }
  MESSAGE("deepest overlap ", deepest, " radii");
}

namespace {

/// A body that passes the plane x = 0, which an obstacle touches, in the distance `gap`.
template <class Shape>
struct passer {
  Shape shape;
  real half;  ///< extent along x
};

/// Flies past an obstacle without gravity, in each phase of the steps; returns how many of these
/// flights end with another velocity.
template <class Shape, class Add>
int turned_aside(const passer<Shape>& p, const vec3& along, real gap, real way, Add&& add) {
  const real dt = 1.0 / 60;
  int turned = 0;
  for (int phase = 0; phase < 8; ++phase) {
    serial::link link;
    world<scenario<bodies<sphere, box, cylinder, convex_polyhedron, triangle_mesh>,
                   transport<serial>>>
        w(link);
    w.material({.density = 1, .restitution = 0.5, .friction = 0.3});
    w.global([&](auto& scope) { add(scope); });
    const vec3 step(0, 0, -way);
    const int before = 4 + static_cast<int>(2 / way);
    const auto b =
        w.add(body<Shape>{.shape = p.shape,
                          .position = along + vec3(p.half + gap, 0, way * (before + phase / 8.0)),
                          .velocity = step / dt});
    for (int k = 0; k < 2 * before; ++k) w.step(dt);
    turned += (w[b].velocity() * dt - step).norm() > 1e-9 * way ||
              w[b].angular_velocity().norm() * dt > 1e-9;
  }
  return turned;
}
/// Solids whose sides touch the plane x = 0 from below, with their upper faces at z = 0.
void add_box(auto& scope) {
  scope.add(body<box>{.shape = box{{1.4, 3.8, 1.8}}, .position = {-0.7, -1.9, -0.9}});
}
void add_hull(auto& scope) {
  const convex_polyhedron h({vec3(0, -2, 0), vec3(0, 2, 0), vec3(-2, 0, 0), vec3(-1, 0, -3)});
  const pose at = placed(h);
  scope.add(
      body<convex_polyhedron>{.shape = h, .position = at.position, .orientation = at.orientation});
}
void add_cylinder(auto& scope) {
  scope.add(body<cylinder>{.shape = cylinder{1, 2}, .position = {-1, 0, -1}});
}
/// The surface of a cube with corners at the origin and at (-1, -1, -1).
void add_mesh(auto& scope) {
  const auto corner = [](int k) { return vec3(k & 1 ? 0 : -1, k & 2 ? 0 : -1, k & 4 ? 0 : -1); };
  std::vector<triangle_mesh::triangle> faces;
  for (const auto& [a, b, c, d] : {std::array{0, 2, 3, 1},
                                   {4, 5, 7, 6},
                                   {0, 1, 5, 4},
                                   {2, 6, 7, 3},
                                   {0, 4, 6, 2},
                                   {1, 3, 7, 5}}) {
    faces.push_back({corner(a), corner(b), corner(c)});
    faces.push_back({corner(a), corner(c), corner(d)});
  }
  const triangle_mesh m(faces);
  const pose at = placed(m);
  scope.add(
      body<triangle_mesh>{.shape = m, .position = at.position, .orientation = at.orientation});
}

}  // namespace

TEST_CASE("boxes, cylinders and hulls that fly past a solid in any small distance go straight on") {
  const auto solids = [](auto&& f) {
    f("box", [](auto& s) { add_box(s); });
    f("hull", [](auto& s) { add_hull(s); });
    f("cylinder", [](auto& s) { add_cylinder(s); });
  };
  const passer<box> crate{{{0.8, 2.9, 1.8}}, 0.4};
  const passer<cylinder> drum{{0.5, 1.5}, 0.5};
  const passer<convex_polyhedron> block{
      convex_polyhedron({vec3(-0.5, -0.5, -0.5), vec3(0.5, -0.5, -0.5), vec3(-0.5, 0.5, -0.5),
                         vec3(0.5, 0.5, -0.5), vec3(-0.5, -0.5, 0.5), vec3(0.5, -0.5, 0.5),
                         vec3(-0.5, 0.5, 0.5), vec3(0.5, 0.5, 0.5)}),
      0.5};
  solids([&](const char* name, const auto& add) {
    CAPTURE(std::string(name));
    for (const real gap : {0.004, 0.0164, 0.03, 0.1})
      for (const real way : {0.05, 0.2, 0.38}) {
        CAPTURE(gap);
        CAPTURE(way);
        CHECK(turned_aside(crate, {0, 0, 0.9}, gap, way, add) == 0);
        CHECK(turned_aside(drum, {0, 0, 0.75}, gap, way, add) == 0);
        CHECK(turned_aside(block, {0, 0, 0.5}, gap, way, add) == 0);
      }
  });
}

TEST_CASE("balls that fly past edges and corners of a closed mesh go straight on") {
  for (const real radius : {0.3, 1.0, 1.6})
    for (const real gap : {0.001, 0.003, 0.03})
      for (const real y : {-0.3, -0.001, 0.0, 0.0012})
        for (const real way : {0.1, 0.45, 1.1}) {
          CAPTURE(radius);
          CAPTURE(gap);
          CAPTURE(y);
          CAPTURE(way);
          const passer<sphere> ball{sphere{radius}, radius};
          CHECK(turned_aside(ball, {0, y * radius, 0}, gap * radius, way * radius,
                             [](auto& s) { add_mesh(s); }) == 0);
        }
}

namespace {

convex_polyhedron hull_of(const box& b) {
  const vec3 h = b.half();
  std::vector<vec3> corners;
  for (unsigned k = 0; k < 8; ++k)
    corners.push_back({k & 1 ? h[0] : -h[0], k & 2 ? h[1] : -h[1], k & 4 ? h[2] : -h[2]});
  return convex_polyhedron(corners);
}
triangle_mesh mesh_of(const box& b) {
  const vec3 h = b.half();
  std::vector<triangle_mesh::triangle> faces;
  for (int k = 0; k < 3; ++k)
    for (const real sign : {-1., 1.}) {
      const int u = (k + 1) % 3, v = (k + 2) % 3;
      const auto at = [&](real x, real y) {
        vec3 p;
        p[k] = sign * h[k], p[u] = sign * x * h[u], p[v] = y * h[v];
        return p;
      };
      faces.push_back({at(-1, -1), at(1, -1), at(1, 1)});
      faces.push_back({at(-1, -1), at(1, 1), at(-1, 1)});
    }
  return triangle_mesh(faces);
}
enum class table_kind { box, hull, mesh, cylinder };

/// A cube of 0.1 falls beside the edge of a fixed table of 0.1 to 100 m, at 1e-5 to 1e-1 of its
/// edge, level or turned by little about the edge, or about the vertical.
template <class Scenario, class Shape>
void check_fall_beside_table(const Shape& shape, table_kind kind, random_stream& random) {
  const real edge = 0.1, table = std::pow(10., random.uniform(-1, 2)),
             dt = std::pow(10., random.uniform(-3.5, -1.8)),
             beside = edge * std::pow(10., random.uniform(-5, -1)), half = 0.5 * edge;
  const int how = static_cast<int>(random.uniform(0, 3));
  const real turn = std::pow(10., random.uniform(-6, -2));
  const quat q = how == 0   ? quat(1, 0, 0, 0)
                 : how == 1 ? rotation({0, 1, 0}, turn)
                            : rotation({0, 0, 1}, turn);
  const real reach = how == 0 ? half : half * (std::cos(turn) + std::sin(turn));
  const vec3 aside(random.uniform(-0.3, 0.3) * table, 0, 0);
  serial::link link;
  world<Scenario> w(link);
  w.gravity({0, 0, -9.81});
  w.material({.density = 1000, .restitution = random.uniform(0, 1), .friction = 0.5});
  w.global([&](auto& s) {
    const box b{{table, table, table}};
    const vec3 at(-0.5 * table, aside[0], -0.5 * table);
    if (kind == table_kind::box) s.add(body<box>{.shape = b, .position = at});
    if (kind == table_kind::hull)
      s.add(body<convex_polyhedron>{.shape = hull_of(b), .position = at});
    if (kind == table_kind::mesh) s.add(body<triangle_mesh>{.shape = mesh_of(b), .position = at});
    if (kind == table_kind::cylinder)
      s.add(body<cylinder>{.shape = cylinder{0.5 * table, table},
                           .position = {-0.5 * table, 0, -0.5 * table}});
  });
  const real speed = edge * std::pow(10., random.uniform(-2, -0.3)) / dt;
  const auto h = w.add(body<Shape>{.shape = shape,
                                   .position = {reach + beside, 0, edge * random.uniform(1, 3)},
                                   .velocity = {0, 0, -speed},
                                   .orientation = q});
  const int steps = std::min(400, static_cast<int>(4 * edge / (speed * dt)) + 2);
  for (int k = 0; k < steps; ++k) w.step(dt);
  const real expected = speed + 9.81 * steps * dt;
  INFO("table ", static_cast<int>(kind), " of ", table, ", dt ", dt, ", beside ", beside / edge,
       " edges, turned ", how, " by ", turn, ", speed ", speed);
  CHECK((vec3(w[h].velocity()) + vec3(0, 0, expected)).norm() < 1e-9 * expected);
}

}  // namespace

TEST_CASE_TEMPLATE("a cube that falls beside a table of any size, as near as 1e-5, falls freely",
                   Policy, solver<nonlinear_gauss_seidel>, solver<reproducible>) {
  using tables =
      scenario<bodies<box, cylinder, convex_polyhedron, triangle_mesh>, transport<serial>, Policy>;
  constexpr std::uint64_t seed = 11;
  CAPTURE(seed);
  random_stream random(seed, 1);
  const box cube{{0.1, 0.1, 0.1}};
  for (int n = 0; n < 800; ++n) {
    CAPTURE(n);
    const auto kind = static_cast<table_kind>(n % 4);
    if (n % 8 < 4)
      check_fall_beside_table<tables>(cube, kind, random);
    else
      check_fall_beside_table<tables>(hull_of(cube), kind, random);
  }
}
