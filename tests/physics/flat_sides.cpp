// Shapes of one's own that are known by their support functions alone rest on their flat sides.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/mesh.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/each_contact.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <variant>
#include <vector>

#include "../../examples/own_shape/lens.hpp"

using namespace talus;

namespace {

/// The part of a ball between two planes.
struct tablet {
  real radius = 1, half = 0.5;
  static constexpr bool finite = true, isotropic = false;
  static constexpr const char* name = "tablet";

  void validate() const {}
  [[nodiscard]] real bounding_radius() const { return radius; }
  [[nodiscard]] real volume() const {
    return 2 * pi * (radius * radius * half - half * half * half / 3);
  }
  [[nodiscard]] vec3 inertia() const {
    const real q = radius * radius, h3 = half * half * half, h5 = h3 * half * half;
    const real z2 = 2 * pi * (q * h3 / 3 - h5 / 5) / volume();
    const real x2 = pi / 2 * (q * q * half - 2 * q * h3 / 3 + h5 / 5) / volume();
    return {x2 + z2, x2 + z2, 2 * x2};
  }
  [[nodiscard]] vec3 support(const vec3& d) const {
    const real length = d.norm(), across = std::hypot(d[0], d[1]);
    if (!(length > 0)) return {0, 0, half};
    const vec3 p = (radius / length) * d;
    if (std::abs(p[2]) <= half) return p;
    const real rim = std::sqrt(radius * radius - half * half), z = std::copysign(half, d[2]);
    return across > 0 ? vec3(rim * d[0] / across, rim * d[1] / across, z) : vec3(0, 0, z);
  }
  [[nodiscard]] vec3 half_extents(const pose& at) const {
    const mat3 axes = at.orientation.toRotationMatrix();
    vec3 half_edges;
    for (int i = 0; i < 3; ++i) {
      const vec3 d(axes(i, 0), axes(i, 1), axes(i, 2));
      half_edges[i] = d.dot(support(d));
    }
    return half_edges;
  }
  friend bool operator==(const tablet&, const tablet&) = default;
};

/// A tetrahedron with a distance around it.
struct smoothed {
  real edge = 1, rounding = 0.1;
  static constexpr bool finite = true, isotropic = false;
  static constexpr bool homogeneous = false;  // (the inertia is that of a ball)
  static constexpr const char* name = "smoothed";

  void validate() const {}
  [[nodiscard]] vec3 corner(int k) const {
    const real s = edge / std::sqrt(real(8));
    return {k < 2 ? s : -s, k % 2 ? -s : s, k == 0 || k == 3 ? s : -s};
  }
  [[nodiscard]] real bounding_radius() const { return edge * std::sqrt(real(0.375)) + rounding; }
  [[nodiscard]] real volume() const { return edge * edge * edge / 3; }
  [[nodiscard]] vec3 inertia() const { return vec3(1, 1, 1) * (0.07 * edge * edge); }
  [[nodiscard]] vec3 support(const vec3& d) const {
    int best = 0;
    for (int k = 1; k < 4; ++k)
      if (d.dot(corner(k)) > d.dot(corner(best))) best = k;
    const real length = d.norm();
    return length > 0 ? vec3(corner(best) + rounding / length * d) : corner(best);
  }
  [[nodiscard]] vec3 half_extents(const pose&) const { return vec3(1, 1, 1) * bounding_radius(); }
  friend bool operator==(const smoothed&, const smoothed&) = default;
};

/// A drum by its support function, with the smallest radius of curvature of its rim.
struct drum {
  real radius = 1, half = 0.5;
  static constexpr bool finite = true, isotropic = false, flat_sides = true;
  static constexpr const char* name = "drum";

  void validate() const {}
  [[nodiscard]] cylinder as_cylinder() const { return cylinder{radius, 2 * half}; }
  [[nodiscard]] real bounding_radius() const { return as_cylinder().bounding_radius(); }
  [[nodiscard]] real smallest_curvature_radius() const { return 0; }
  [[nodiscard]] real volume() const { return as_cylinder().volume(); }
  [[nodiscard]] vec3 inertia() const { return as_cylinder().inertia(); }
  [[nodiscard]] vec3 support(const vec3& d) const { return as_cylinder().support(d); }
  [[nodiscard]] vec3 half_extents(const pose& at) const { return as_cylinder().half_extents(at); }
  friend bool operator==(const drum&, const drum&) = default;
};
/// A lens that looks for flat sides, and has none.
struct thin : lens {
  static constexpr bool flat_sides = true;
  static constexpr const char* name = "thin";
};
/// A wedge whose edge lies along x; it returns the middle of the edge where both ends are as far.
struct wedge {
  static constexpr bool finite = true, isotropic = false, homogeneous = false;
  static constexpr const char* name = "wedge";
  void validate() const {}
  [[nodiscard]] real bounding_radius() const { return std::sqrt(real(3)); }
  [[nodiscard]] real volume() const { return 4; }
  [[nodiscard]] vec3 inertia() const { return {0.4, 0.4, 0.4}; }
  [[nodiscard]] vec3 support(const vec3& d) const {
    const real x = d[0] > 0 ? 1 : d[0] < 0 ? -1 : 0;
    return std::abs(d[1]) + d[2] > -d[2] ? vec3(x, std::copysign(real(1), d[1]), 1)
                                         : vec3(x, 0, -1);
  }
  [[nodiscard]] vec3 half_extents(const pose&) const { return vec3(1, 1, 1) * bounding_radius(); }
  friend bool operator==(const wedge&, const wedge&) = default;
};

/// The contacts of a body whose centre is at that height over a plane.
template <class Shape>
std::vector<loaded_contact> contacts_at(const Shape& shape, real height) {
  std::vector<loaded_contact> all;
  threads::launch({.ranks = 1}, [&](auto& link) {
    world<scenario<bodies<Shape, plane>, transport<threads>>> w(link);
    const auto m = w.material({.density = 1});
    w.gravity({0, 0, -9.81});
    w.global([&](auto& s) { s.add(plane{}, m); });
    w.add(body{.shape = shape, .position = {0, 0, height}, .material = m});
    w.step(1e-3);
    for_each_contact(w, [&](const loaded_contact& c) { all.push_back(c); });
  });
  return all;
}

using scene = scenario<bodies<tablet, smoothed, box, triangle_mesh, plane>,
                       decomposition<grid<dynamic, dynamic>>, transport<threads>>;

/// Checks that after five seconds no body moves for so many further steps.
void check_rest(world<scene>& w, int steps) {
  for (int k = 0; k < 1200; ++k) w.step(1. / 240);
  std::vector<vec3> before;
  w.for_each_local([&](const auto& b) { before.push_back(b.position()); });
  for (int k = 0; k < steps; ++k) w.step(1. / 240);
  std::size_t n = 0;
  w.for_each_local([&](const auto& b) {
    CAPTURE(b.position());
    CHECK(b.velocity().norm() < 1e-8);
    CHECK(b.angular_velocity().norm() < 1e-8);
    CHECK((b.position() - before[n++]).norm() < 1e-8);
  });
}

}  // namespace

TEST_CASE("the member flat_sides decides, and thin round shapes have no flat side") {
  CHECK(contacts_at(drum{}, 0.5).size() == 16);
  for (const real t : {0.5, 0.05, 0.01, 0.005, 0.002}) {
    CAPTURE(t);
    thin one;
    one.radius = 1, one.thickness = t;
    const auto contacts = contacts_at(one, t / 2);
    CHECK(contacts.size() == 1);
    for (const auto& c : contacts) CHECK(std::abs(c.gap) < 1e-4 * t);
  }
  CHECK(contacts_at(wedge{}, 1).size() >= 2);
}

TEST_CASE("bodies rest on flat sides that their support functions alone have") {
  for (const int ranks : {1, 2})
    for (const real lean : {0., 0.01, 0.2})
      threads::launch({.ranks = ranks}, [&](auto& link) {
        CAPTURE(ranks);
        CAPTURE(lean);
        world<scene> w(link);
        w.decompose({.cells = {ranks, 1}, .lower = {-9, -9}, .upper = {9, 9}});
        w.gravity({0, 0, -9.81});
        const auto m = w.material({.density = 2, .restitution = 0, .friction = 0.5});
        w.global([&](auto& s) {
          s.add(plane{}, m);
          s.add(body{.shape = box{{3, 3, 1}}, .position = {4, 0, 0.5}, .material = m});
          const triangle_mesh floor(std::vector<triangle_mesh::triangle>{
              {vec3(-6, -2, 1), vec3(-2, -2, 1), vec3(-2, 2, 1)},
              {vec3(-6, -2, 1), vec3(-2, 2, 1), vec3(-6, 2, 1)}});
          const pose at = placed(floor);
          s.add(body<triangle_mesh>{.shape = floor,
                                    .position = at.position,
                                    .material = m,
                                    .orientation = at.orientation});
        });
        const quat turn = rotation({1, 0.3, 0}, lean);
        const quat face = turn * rotation({1, -1, 0}, std::acos(1 / std::sqrt(real(3))));
        for (const vec3& x : {vec3(0, 0, 0), vec3(4, 0, 1), vec3(-4, 0, 1)}) {
          const real z = x[2] + 2 * lean;
          w.add_if_local(body{.shape = tablet{},
                              .position = {x[0], -0.5, z + 0.5},
                              .material = m,
                              .orientation = turn});
          w.add_if_local(body{.shape = smoothed{},
                              .position = {x[0], 1, z + 0.31},
                              .material = m,
                              .orientation = face});
        }
        check_rest(w, 240);
        int contacts = 0;
        for_each_contact(w, [&](const loaded_contact&) { ++contacts; });
        if (ranks == 1) CHECK(contacts >= 3 * (3 + 3));
      });
}

TEST_CASE("stacks stand whose flat sides their support functions alone have") {
  for (const int ranks : {1, 2, 4})
    for (const real lean : {0., 0.02})
      threads::launch({.ranks = ranks}, [&](auto& link) {
        CAPTURE(ranks);
        CAPTURE(lean);
        world<scene> w(link);
        w.decompose({.cells = {ranks, 1}, .lower = {-9, -9}, .upper = {9, 9}});
        w.gravity({0, 0, -9.81});
        const auto m = w.material({.density = 2, .restitution = 0, .friction = 0.5});
        w.global([&](auto& s) { s.add(plane{}, m); });
        const quat turn = rotation({1, 0.3, 0}, lean);
        const quat face = turn * rotation({1, -1, 0}, std::acos(1 / std::sqrt(real(3))));
        for (int k = 0; k < 3; ++k)  // over the border between the ranks
          w.add_if_local(body{.shape = tablet{},
                              .position = {k % 2 ? 0.2 : -0.2, 0, 0.5 + k * (1 + lean)},
                              .material = m,
                              .orientation = turn});
        w.add_if_local(
            body{.shape = tablet{}, .position = {4, 0, 0.5}, .material = m, .orientation = turn});
        w.add_if_local(body{.shape = smoothed{},
                            .position = {4, 0, 1.31 + 2 * lean},
                            .material = m,
                            .orientation = face});
        check_rest(w, 1200);
      });
}

TEST_CASE("bodies with flat sides move alike on any ranks and after a restart") {
  using alike =
      scenario<bodies<tablet, smoothed, box, plane>, solver<reproducible>,
               decomposition<grid<dynamic, dynamic>>, transport<threads>, features<checkpoints>>;
  const std::string file = "/tmp/talus_flat_sides_" + std::to_string(getpid()) + ".h5";
  constexpr int restart = 450;  // while they fall, roll and come to rest
  /// The digest at the end; at the restart the state is read from the file, or written to it.
  const auto move = [&](int ranks, bool restarts, int steps) {
    std::string digest;
    threads::launch({.ranks = ranks}, [&](auto& link) {
      world<alike> w(link);
      const int across = ranks > 2 ? 2 : 1;
      w.decompose({.cells = {ranks / across, across}, .lower = {-3, -3}, .upper = {3, 3}});
      w.gravity({0, 0, -9.81});
      const auto m = w.material({.density = 2, .restitution = 0, .friction = 0.3});
      w.global([&](auto& s) {
        s.add(plane{}, m);
        s.add(body{.shape = box{{2, 2, 1}}, .position = {0.3, 0.2, 0.5}, .material = m});
      });
      if (restarts)
        read_checkpoint(w, file);
      else
        w.fill(simple_cubic{.spacing = 1.1} & box_region{{-2, -2, 1.8}, {2, 2, 5}},
               [&](const site& place,
                   random_stream& random) -> std::variant<body<tablet>, body<smoothed>> {
                 const quat turn = random.rotation();
                 if (random.integer(2) == 0)
                   return body{.shape = tablet{0.5, 0.2},
                               .position = place.position,
                               .material = m,
                               .orientation = turn};
                 return body{.shape = smoothed{0.7, 0.05},
                             .position = place.position,
                             .material = m,
                             .orientation = turn};
               });
      for (int k = 0; k < steps; ++k) w.step(1. / 400);
      if (steps == restart) write_checkpoint(w, file);
      const std::string of_all = state_digest(w);
      if (link.rank() == 0) digest = of_all;
    });
    return digest;
  };
  const std::string expected = move(1, false, 700);
  CHECK(move(4, false, 700) == expected);
  for (const auto& [before, after] : {std::pair{1, 4}, {4, 2}, {2, 1}}) {
    CAPTURE(before);
    CAPTURE(after);
    move(before, false, restart);
    CHECK(move(after, true, 700 - restart) == expected);
  }
  unlink(file.c_str());
}
