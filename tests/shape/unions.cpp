// Unions: mass, centre, inertia and bounds follow from the parts.
#include <doctest/doctest.h>

#include <random>

#include "../generator.hpp"
#include "../vectors.hpp"
#include "talus/concepts.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/capsule.hpp"
#include "talus/shape/convex_polyhedron.hpp"
#include "talus/shape/cylinder.hpp"
#include "talus/shape/ellipsoid.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/shape/superellipsoid.hpp"
#include "talus/shape/union_of.hpp"

namespace {

using namespace talus;
using any_union = union_of<sphere, box, capsule, cylinder, convex_polyhedron>;
static_assert(concepts::finite_shape<any_union>);
static_assert(!any_union::isotropic);

/// A box that is clipped by lines, since it is not known to have flat faces.
struct rough_box {
  box of;
  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "rough_box";
  void validate() const {}
  [[nodiscard]] real bounding_radius() const { return of.bounding_radius(); }
  [[nodiscard]] real volume() const { return of.volume(); }
  [[nodiscard]] vec3 inertia() const { return of.inertia(); }
  [[nodiscard]] vec3 support(const vec3& d) const { return of.support(d); }
  [[nodiscard]] vec3 half_extents(const pose& at) const { return of.half_extents(at); }
  [[nodiscard]] talus::chord chord(const vec3& p, const vec3& d) const { return of.chord(p, d); }
};

/// A shape of a user's own, known by its support function alone.
template <class Of>
struct own {
  Of of;
  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "own";
  void validate() const {}
  [[nodiscard]] real bounding_radius() const { return of.bounding_radius(); }
  [[nodiscard]] real volume() const { return of.volume(); }
  [[nodiscard]] vec3 inertia() const { return of.inertia(); }
  [[nodiscard]] vec3 support(const vec3& d) const { return of.support(d); }
  [[nodiscard]] vec3 half_extents(const pose& at) const { return of.half_extents(at); }
  [[nodiscard]] decltype(auto) frame() const requires requires { of.frame(); }
  { return of.frame(); }
  template <class Writer>
  void pack(Writer& out) const requires requires {
    of.pack(out);
  }
  { of.pack(out); }
  template <class Reader>
  static own unpack(Reader& in) requires requires {
    Of::unpack(in);
  }
  { return {Of::unpack(in)}; }
  friend bool operator==(const own&, const own&) = default;
};

bool inside(const sphere& s, const vec3& p) { return p.norm() <= s.radius; }
bool inside(const box& s, const vec3& p) { return at_most((2 * p).cwiseAbs(), s.size); }
bool inside(const capsule& s, const vec3& p) {
  return std::hypot(p[0], p[1], std::max(0., std::abs(p[2]) - s.length / 2)) <= s.radius;
}
bool inside(const cylinder& s, const vec3& p) {
  return std::hypot(p[0], p[1]) <= s.radius && std::abs(p[2]) <= s.length / 2;
}
bool inside(const convex_polyhedron& s, const vec3& p) {
  for (std::size_t f = 0; f < s.mesh().faces(); ++f)
    if (s.mesh().normals[f].dot(p) > s.mesh().offsets[f]) return false;
  return true;
}

template <class F>
std::string message_of(F&& f) {
  try {
    f();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

/// Mass, centre and inertia of a union against samples in its frame.
template <class Parts>
void check_by_sampling(const any_union& u, const Parts& parts, bool once, generator& random) {
  const vec3 half = u.half_extents(pose{});
  const int n = 60;
  real mass = 0;
  vec3 centre = vec3::Zero(), square = vec3::Zero(), mixed = vec3::Zero();
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const vec3 p =
            (vec3(x + random(0, 1), y + random(0, 1), z + random(0, 1)) * (2. / n) - vec3(1, 1, 1))
                .cwiseProduct(half);
        real weight = 0;
        std::size_t number = 0;
        u.each_part([&](const auto& s, const pose& place) {
          const real density = parts[number++].density;
          if (inside(s, place.to_body(p)))
            weight = once ? std::max(weight, density) : weight + density;
        });
        mass += weight;
        centre += weight * p;
        square += weight * p.cwiseProduct(p);
        mixed += weight * vec3(p[1] * p[2], p[2] * p[0], p[0] * p[1]);
      }
  const real radius = u.bounding_radius();
  CHECK(8 * product_of(half) * mass / (real(n) * n * n) ==
        doctest::Approx(u.volume()).epsilon(5e-3));
  const vec3 m = square / mass;
  for (int i = 0; i < 3; ++i) {
    CHECK(u.inertia()[i] == doctest::Approx(m[(i + 1) % 3] + m[(i + 2) % 3]).epsilon(5e-3));
    CHECK(std::abs(centre[i] / mass) < 3e-3 * radius);
    CHECK(std::abs(mixed[i] / mass) < 3e-3 * radius * radius);
  }
}

/// Whether two unions have the same mass, centre and inertia, relative to the size, up to a
/// rotation of the axes.
void check_same_moments(const auto& u, const auto& v, real tolerance) {
  CHECK(u.volume() == doctest::Approx(v.volume()).epsilon(tolerance));
  CHECK((u.frame().position - v.frame().position).norm() < tolerance * u.bounding_radius());
  const auto sorted = [](vec3 x) {
    std::sort(&x[0], &x[0] + 3);
    return x;
  };
  const vec3 a = sorted(u.inertia()), b = sorted(v.inertia());
  CHECK((a - b).norm() < tolerance * b.norm());
}

using balls = union_of<sphere>;

}  // namespace

TEST_CASE("two spheres that overlap have the volume and the inertia of the closed form") {
  // Half of the union is a sphere beyond a plane at distance d / 2 from its centre.
  for (const real d : {0.2, 1., 1.9}) {
    const balls u({{.shape = sphere{1}, .at = {{-d / 2, 0, 0}}},
                   {.shape = sphere{1}, .at = {{d / 2, 0, 0}}}});
    // Disks of the radius squared 1 - (x - d / 2)^2 for x from 0 to 1 + d / 2.
    const int n = 200000;
    const real top = 1 + d / 2;
    real volume = 0, axial = 0, across = 0;
    for (int k = 0; k < n; ++k) {
      const real x = (k + 0.5) * top / n, area = pi * (1 - (x - d / 2) * (x - d / 2));
      volume += area * top / n, axial += area * area / (2 * pi) * top / n;
      across += area * (area / (4 * pi) + x * x) * top / n;
    }
    CHECK(u.volume() == doctest::Approx(2 * volume).epsilon(1e-9));
    const real lens = pi * (4 + d) * (2 - d) * (2 - d) / 12;
    CHECK(u.volume() == doctest::Approx(8 * pi / 3 - lens).epsilon(1e-14));
    CHECK(u.inertia()[0] == doctest::Approx(axial / volume).epsilon(1e-9));
    CHECK(u.inertia()[1] == doctest::Approx(across / volume).epsilon(1e-9));
    CHECK(u.frame().position.norm() < 1e-15);
  }
  // Of different sizes, in any direction, and one inside the other.
  const real a = 1, b = 0.7, d = 1.2;
  const vec3 way = vec3(1, 2, -2) / 3;
  const balls u({{.shape = sphere{a}, .at = {{3, 4, 5}}},
                 {.shape = sphere{b}, .at = {vec3(3, 4, 5) + d * way}}});
  const real lens =
      pi * (a + b - d) * (a + b - d) * (d * d + 2 * d * (a + b) - 3 * (a - b) * (a - b)) / (12 * d);
  CHECK(u.volume() == doctest::Approx(4 * pi / 3 * (a * a * a + b * b * b) - lens).epsilon(1e-14));
  const balls inner({{.shape = sphere{0.3}, .at = {{0.1, 0, 0}}}, {.shape = sphere{1}}});
  check_same_moments(inner, balls({{.shape = sphere{1}}}), 1e-14);
  const balls dense({{.shape = sphere{1}}, {.shape = sphere{0.5}, .density = 3}});
  CHECK(dense.volume() == doctest::Approx(4 * pi / 3 * (1 + 2 * 0.125)).epsilon(1e-14));
}

TEST_CASE(
    "three spheres that overlap in pairs and in a triple have the volume of the closed form") {
  for (const real d : {0.05, 0.3, 1., 1.5}) {
    CAPTURE(d);
    // Of what three unit spheres at distances d share, by the theorem of Gauss: a face of it lies
    // in two caps of a sphere, whose axes are at 60 degrees. Area by Gauss and Bonnet
    // (Tovchigrechko, Vakser 2001); the integral of the normal is half of that of r x dr along two
    // arcs.
    const real c = d / 2, s = std::sqrt(1 - c * c), phi = pi / 3;
    const real half = std::acos((c - c * std::cos(phi)) / (s * std::sin(phi)));
    const real area = 2 * pi - 2 * std::acos((std::cos(phi) - c * c) / (s * s)) - 4 * c * half;
    const vec3 first(-std::sqrt(3.) / 2, 0.5, 0), second(-std::sqrt(3.) / 2, -0.5, 0);
    const auto of_arc = [&](const vec3& axis, const vec3& other) {
      const vec3 towards = (other - std::cos(phi) * axis).normalized();
      return vec3(s * s * half * axis - c * s * std::sin(half) * towards);
    };
    const vec3 normal = of_arc(first, second) + of_arc(second, first);
    const real triple = area + d / std::sqrt(3.) * normal[0];
    const real lens = pi * (4 + d) * (2 - d) * (2 - d) / 12;
    const quat turn = rotation({3, 1, 2}, 0.9);
    std::vector<balls::part> parts;
    for (int k = 0; k < 3; ++k) {
      const real angle = 2 * pi * k / 3;
      const vec3 at = d / std::sqrt(3.) * vec3(std::cos(angle), std::sin(angle), 0);
      parts.push_back({.shape = sphere{1}, .at = {vec3(1, 2, 3) + turn * at}});
    }
    const balls u(parts);
    CHECK(u.volume() == doctest::Approx(4 * pi - 3 * lens + triple).epsilon(1e-10));
    CHECK((u.frame().position - vec3(1, 2, 3)).norm() < 1e-9);
  }
  // On a line: a body of revolution, of segments of spheres.
  const auto segment = [](real from, real to) {
    return pi * (to - from - (to * to * to - from * from * from) / 3);
  };
  const vec3 way = vec3(2, -1, 2) / 3;
  const balls row({{.shape = sphere{1}, .at = {-0.6 * way}},
                   {.shape = sphere{1}},
                   {.shape = sphere{1}, .at = {0.6 * way}}});
  CHECK(row.volume() == doctest::Approx(2 * segment(-0.3, 1) + segment(-0.3, 0.3)).epsilon(1e-10));
}

TEST_CASE("overlapping spheres weigh what lines through them say, in any order and turned") {
  generator random{std::mt19937_64(7)};
  for (int trial = 0; trial < 12; ++trial) {
    CAPTURE(trial);
    std::vector<balls::part> parts;
    const int n = 3 + trial;
    for (int k = 0; k < n; ++k)
      parts.push_back({.shape = sphere{random(0.3, 0.8)},
                       .at = {random.point({1, 1, 1})},
                       .density = trial % 3 == 2 ? random(0.5, 2) : 1});
    // Equal heights, and centres above each other.
    if (trial % 4 == 1) {
      for (auto& p : parts) p.at.position[2] = 0, p.shape = sphere{0.6};
      parts[1].at.position = parts[0].at.position + vec3(0, 0, 0.5);
      parts[2] = parts[0];
    }
    const balls u(parts);
    // By lines: as capsules without a length.
    if (trial < 6) {
      using rods = union_of<capsule>;
      std::vector<rods::part> thick;
      for (const auto& p : parts)
        thick.push_back({.shape = capsule{std::get<sphere>(p.shape).radius, 1e-10},
                         .at = p.at,
                         .density = p.density});
      check_same_moments(u, rods(thick), 1e-6);
    }
    // The same in another order, and turned.
    std::vector<balls::part> other(parts.rbegin(), parts.rend());
    check_same_moments(u, balls(other), 1e-9);
    const quat turn = random.turn();
    for (auto& p : parts) p.at.position = turn * p.at.position;
    const balls turned(parts);
    CHECK(turned.volume() == doctest::Approx(u.volume()).epsilon(1e-9));
    CHECK((turned.frame().position - turn * u.frame().position).norm() < 1e-9);
    CHECK(detail::trace(detail::diagonal_matrix(turned.inertia())) ==
          doctest::Approx(detail::trace(detail::diagonal_matrix(u.inertia()))).epsilon(1e-9));
  }
}

TEST_CASE("many spheres that all overlap need slabs in proportion to their number") {
  generator random{std::mt19937_64(11)};
  using ball = detail::part_ball<real>;
  for (const std::size_t n : {25u, 100u}) {
    CAPTURE(n);
    const ball one{{0, 0, 0}, 1};
    std::vector<ball> others;
    for (std::size_t k = 1; k < n; ++k)
      others.push_back({random.point({0.4, 0.4, 0.4}) + vec3(0.3, 0.2, 0.1), random(0.7, 0.9)});
    detail::shared_by_many<real> given(one, others);
    const auto shared = given.moments();
    CHECK(given.slabs() > 2);
    CHECK(given.slabs() <= 6 * n);
    CHECK(shared.mass < 4 * pi / 3);
    // In another order, and turned, the same.
    std::reverse(others.begin(), others.end());
    for (ball& b : others) b.centre = {b.centre[1], b.centre[2], b.centre[0]};
    const auto again = detail::shared_by_many<real>(one, others).moments();
    CHECK(again.mass == doctest::Approx(shared.mass).epsilon(1e-9));
    CHECK((again.first - vec3(shared.first[1], shared.first[2], shared.first[0])).norm() < 1e-9);
  }
}

TEST_CASE("parts of other shapes that overlap weigh their true volume to 1e-6") {
  using some = union_of<sphere, box, capsule, cylinder>;
  const auto same = [](const some& u, const some& v) { check_same_moments(u, v, 1e-6); };
  const pose tilted{{1, 2, 3}, rotation({1, 2, 3}, 0.7)};
  const auto at = [&](const vec3& p) { return pose{tilted.to_world(p), tilted.orientation}; };
  // A box of two that overlap, one that is inside, and one that crosses.
  same(some({{.shape = box{{2, 1, 1}}, .at = at({0, 0, 0})},
             {.shape = box{{2, 1, 1}}, .at = at({1, 0, 0})},
             {.shape = box{{0.3, 0.2, 0.1}}, .at = at({0.2, 0.1, 0})}}),
       some({{.shape = box{{3, 1, 1}}, .at = at({0.5, 0, 0})}}));
  // A capsule from its cylinder and two spheres.
  same(some({{.shape = cylinder{0.4, 1.5}, .at = at({0, 0, 0})},
             {.shape = sphere{0.4}, .at = at({0, 0, -0.75})},
             {.shape = sphere{0.4}, .at = at({0, 0, 0.75})}}),
       some({{.shape = capsule{0.4, 1.5}, .at = at({0, 0, 0})}}));
  // Two crossing cylinders of one radius share 16/3 r^3 (Archimedes).
  const some cross({{.shape = cylinder{0.5, 3}},
                    {.shape = cylinder{0.5, 3}, .at = {{0, 0, 0}, rotation({1, 0, 0}, pi / 2)}}});
  CHECK(cross.volume() == doctest::Approx(2 * pi * 0.25 * 3 - 16. / 3 * 0.125).epsilon(1e-6));
  // Parts that are small beside another, wherever they lie and however thin they are.
  for (const real place : {-4., -1.13, 0.37, 1.4142, 4.}) {
    CAPTURE(place);
    const real w = 0.1, thin = 0.025, r = 0.1;
    const quat along_y = rotation({1, 0, 0}, pi / 2);
    const some pins({{.shape = box{{10, 10, 10}}},
                     {.shape = cylinder{w, 10}, .at = {{0, 0, -4.5}, along_y}, .density = 3},
                     {.shape = cylinder{w, 10}, .at = {{0, 0, place}, along_y}, .density = 3},
                     {.shape = cylinder{w, 10}, .at = {{0, 0, 4.5}, along_y}, .density = 3}});
    CHECK(pins.volume() == doctest::Approx(1000 + 2 * 3 * 10 * pi * w * w).epsilon(1e-6));
    // A tilted needle, whose bounds are wide, and a sphere.
    const pose at{{place / 8, place / 4, -place / 4}, rotation({1, 0, 0}, 0.6)};
    const some needle(
        {{.shape = box{{4, 6, 6}}}, {.shape = cylinder{thin, 4}, .at = at, .density = 3}});
    CHECK(needle.volume() == doctest::Approx(144 + 2 * 4 * pi * thin * thin).epsilon(1e-6));
    const some seed({{.shape = box{{4, 6, 6}}}, {.shape = sphere{r}, .at = at, .density = 3}});
    CHECK(seed.volume() == doctest::Approx(144 + 2 * 4 * pi / 3 * r * r * r).epsilon(1e-6));
  }
  // What only touches, side by side, counts in full.
  const some blocks({{.shape = box{{1, 1, 1}}}, {.shape = box{{1, 1, 1}}, .at = {{1, 0, 0}}}});
  CHECK(blocks.volume() == 2);
}

TEST_CASE("an ellipsoid shares its volume with other parts once") {
  using eggs = union_of<sphere, ellipsoid>;
  const pose turned{{0.4, 0.3, -0.2}, rotation({1, 2, 3}, 0.7)};
  check_same_moments(eggs({{.shape = ellipsoid{{1, 1, 1}}}, {.shape = sphere{0.8}, .at = turned}}),
                     eggs({{.shape = sphere{1}}, {.shape = sphere{0.8}, .at = turned}}), 1e-6);
  check_same_moments(
      eggs({{.shape = ellipsoid{{2, 1, 1.5}}, .at = turned}, {.shape = sphere{0.9}, .at = turned}}),
      eggs({{.shape = ellipsoid{{2, 1, 1.5}}, .at = turned}}), 1e-6);
}

TEST_CASE("a superellipsoid shares its volume with other parts once") {
  using grains = union_of<superellipsoid, ellipsoid, box>;
  const pose turned{{0.4, 0.3, -0.2}, rotation({1, 2, 3}, 0.7)};
  const ellipsoid egg{{0.5, 0.9, 0.7}};
  check_same_moments(grains({{.shape = superellipsoid{{2, 1, 1.5}}}, {.shape = egg, .at = turned}}),
                     grains({{.shape = ellipsoid{{2, 1, 1.5}}}, {.shape = egg, .at = turned}}),
                     1e-6);
  // One inside another, in the corner of which only a blocky one has room.
  const superellipsoid block{{1, 1, 1}, 8, 8};
  check_same_moments(
      grains({{.shape = block}, {.shape = box{{0.2, 0.2, 0.2}}, .at = {{0.7, 0.7, 0.7}}}}),
      grains({{.shape = block}}), 1e-6);
}

TEST_CASE("a shape of one's own without chords shares its volume with other parts once") {
  const pose turned{{0.4, 0.3, -0.2}, rotation({1, 2, 3}, 0.7)};
  const auto test = [&](const auto& shape, const auto& other) {
    using of = std::decay_t<decltype(shape)>;
    using with = std::decay_t<decltype(other)>;
    INFO(of::name << " and " << with::name);
    const union_of<of, with> known({{.shape = shape}, {.shape = other, .at = turned}});
    const union_of<own<of>, with> one(
        {{.shape = own<of>{shape}}, {.shape = other, .at = turned, .density = 1}});
    check_same_moments(known, one, 2e-6);
    CHECK(one.volume() < (1 - 1e-3) * (shape.volume() + other.volume()));
    // In the other order, both by their support functions.
    const union_of<own<of>, own<with>> both(
        {{.shape = own<with>{other}, .at = turned}, {.shape = own<of>{shape}}});
    check_same_moments(known, both, 2e-6);
  };
  test(ellipsoid{{1, 0.7, 0.5}}, sphere{0.6});
  test(box{{1, 0.7, 0.5}}, sphere{0.6});
  test(cylinder{0.5, 0.9}, box{{1, 0.7, 0.5}});
  test(capsule{0.3, 0.9}, ellipsoid{{1, 0.7, 0.5}});
  test(convex_polyhedron({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1.5}}), cylinder{0.3, 0.5});
  // A copy inside of itself, and a part that only touches.
  using own_ball = own<ellipsoid>;
  const own_ball ball{{{0.5, 0.5, 0.5}}};
  CHECK(union_of<own_ball>({{.shape = ball}, {.shape = ball}}).volume() ==
        doctest::Approx(ball.volume()).epsilon(1e-6));
  CHECK(union_of<own_ball>({{.shape = ball}, {.shape = ball, .at = {{1, 0, 0}}}}).volume() ==
        doctest::Approx(2 * ball.volume()).epsilon(1e-9));
}

TEST_CASE("boxes and polyhedra that overlap weigh their true volume to round-off") {
  using blocks = union_of<box, convex_polyhedron>;
  // A cube turned by 45 degrees in another one: they share an octagon.
  const blocks star({{.shape = box{{1, 1, 1}}},
                     {.shape = box{{1, 1, 1}}, .at = {{0, 0, 0}, rotation({0, 0, 1}, pi / 4)}}});
  CHECK(star.volume() == doctest::Approx(2 - 2 * (std::sqrt(2.) - 1)).epsilon(1e-13));
  // A corner of a cube cut off by a polyhedron.
  const blocks corner(
      {{.shape = box{{2, 2, 2}}, .at = {{1, 1, 1}}},
       {.shape = convex_polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), .density = 7}});
  CHECK(corner.volume() == doctest::Approx(8 + 6. / 6).epsilon(1e-13));
  generator random{std::mt19937_64(4)};
  for (int trial = 0; trial < 8; ++trial) {
    CAPTURE(trial);
    std::vector<blocks::part> parts;
    std::vector<union_of<rough_box>::part> rough;
    for (int k = 0; k < 2 + trial; ++k) {
      const box b{{random(0.4, 1.5), random(0.4, 1.5), random(0.4, 1.5)}};
      const pose at{random.point(0.5), random.turn()};
      const real density = trial % 2 == 0 ? 1 : random(0.5, 2);
      parts.push_back({.shape = b, .at = at, .density = density});
      rough.push_back({.shape = rough_box{b}, .at = at, .density = density});
    }
    const blocks u(parts);
    check_same_moments(u, blocks(std::vector<blocks::part>(parts.rbegin(), parts.rend())), 1e-12);
    if (trial < 3) check_same_moments(u, union_of<rough_box>(rough), 1e-6);
  }
}

TEST_CASE("a symmetric clump keeps its axes, and equal unions are computed once") {
  const auto tetrahedron = [] {
    std::vector<balls::part> parts;
    for (const vec3& p : {vec3(1, 1, 1), vec3(1, -1, -1), vec3(-1, 1, -1), vec3(-1, -1, 1)})
      parts.push_back({.shape = sphere{0.5}, .at = {0.3 * p}});
    return balls(parts);
  };
  const balls u = tetrahedron();
  CHECK(u.frame().orientation.w() == 1);
  CHECK(u.frame().position.norm() < 1e-10);
  CHECK(u.inertia()[0] == doctest::Approx(u.inertia()[2]).epsilon(1e-8));
  const auto parts_of = [](const balls& b) {
    const sphere* first = nullptr;
    b.each_part([&](const sphere& s, const pose&) { first = first == nullptr ? &s : first; });
    return first;
  };
  CHECK(parts_of(tetrahedron()) == parts_of(u));
  // The last ones are kept although no body has them.
  int made = 0;
  struct numbered {
    int number;
  };
  const auto get = [&](std::uint64_t name) {
    return detail::made_once<numbered>(
               {name, 0}, [&] { return std::make_shared<const numbered>(numbered{++made}); })
        ->number;
  };
  constexpr std::uint64_t held = detail::made_data<numbered>::held;
  for (int round = 0; round < 3; ++round)
    for (std::uint64_t name = 0; name < held; ++name) CHECK(get(name) == int(name) + 1);
  CHECK(get(held) == int(held) + 1);
  CHECK(get(0) == int(held) + 2);
}

TEST_CASE("mass, centre, inertia and bounds of a union agree with sampling its parts") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    std::vector<any_union::part> parts;
    const auto at = [&] { return pose{random.point({1, 1, 1}) + vec3(4, 5, 6), random.turn()}; };
    parts.push_back({.shape = sphere{0.6}, .at = at()});
    parts.push_back({.shape = box{{0.7, 1.3, 0.4}}, .at = at(), .density = 2});
    parts.push_back({.shape = capsule{0.3, 1.1}, .at = at()});
    parts.push_back({.shape = cylinder{0.5, 0.9}, .at = at(), .density = 0.5});
    parts.push_back({.shape = convex_polyhedron({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1.5}}),
                     .at = at(),
                     .density = 3});
    if (seed == 6) parts[1].density = parts[2].density = 0;
    const any_union u(parts);
    CHECK_NOTHROW(u.validate());
    CHECK(u.parts() == parts.size());

    const any_union counted(parts, {.overlaps = overlap_rule::counted});
    real expected = 0;
    for (const auto& p : parts)
      expected += p.density * std::visit([](const auto& s) { return s.volume(); }, p.shape);
    CHECK(counted.volume() == doctest::Approx(expected).epsilon(1e-14));
    CHECK(u.volume() < expected);

    // Sampling in the frame of the body; the density at a point is the largest of the parts around
    // it, or their sum.
    const bool once = seed % 2 == 1;
    check_by_sampling(once ? u : counted, parts, once, random);
    const real radius = u.bounding_radius();

    // Support and bounds.
    real furthest = 0;
    for (int k = 0; k < 20000; ++k) {
      const vec3 d = random.direction(), p = u.support(d);
      furthest = std::max(furthest, p.norm());
      if (k >= 200) continue;
      bool within = false;
      u.each_part([&](const auto& s, const pose& place) {
        within = within || inside(s, place.to_body(p) * (1 - 1e-9));
        CHECK(d.dot(place.to_world(s.support(place.orientation.conjugate() * d))) <=
              d.dot(p) + 1e-12);
      });
      CHECK(within);
      CHECK((u.support(1e-200 * d) - p).norm() < 1e-9);
    }
    CHECK(furthest <= radius * (1 + 1e-12));
    CHECK(furthest > 0.998 * radius);
    for (int k = 0; k < 20; ++k) {
      const pose place{random.point({9, 9, 9}), random.turn()};
      const vec3 box_half = u.half_extents(place);
      for (int axis = 0; axis < 3; ++axis) {
        real reach = 0;
        for (const real sign : {-1., 1.})
          reach = std::max(
              reach, sign * (place.orientation * u.support(place.orientation.conjugate() *
                                                           vec3(sign * vec3::Unit(axis))))[axis]);
        CHECK(reach == doctest::Approx(box_half[axis]));
      }
    }

    // Parts are at their original positions if the body has the pose of placed().
    const pose given{random.point({3, 3, 3}), random.turn()}, body = placed(u, given);
    std::size_t number = 0;
    u.each_part([&](const auto& s, const pose& place) {
      const pose there = detail::combined(body, place),
                 wanted = placed(s, detail::combined(given, parts[number++].at));
      CHECK((there.position - wanted.position).norm() < 1e-12);
      CHECK(std::abs(there.orientation.dot(wanted.orientation)) ==
            doctest::Approx(1).epsilon(1e-12));
    });
  }
}

TEST_CASE("two spheres side by side have the inertia of the textbook") {
  using pair = union_of<sphere>;
  const pair u(
      {{.shape = sphere{1}, .at = {{10, 0, 2}}}, {.shape = sphere{1}, .at = {{10, 0, 4}}}});
  CHECK(u.volume() == doctest::Approx(8 * pi / 3));
  CHECK((u.frame().position - vec3(10, 0, 3)).norm() < 1e-14);
  CHECK(u.frame().orientation.w() == 1);
  CHECK((u.inertia() - vec3(1.4, 1.4, 0.4)).norm() < 1e-14);
  CHECK(u.bounding_radius() == doctest::Approx(2));

  // A box cut into eight is a box.
  using blocks = union_of<box>;
  std::vector<blocks::part> parts;
  for (unsigned c = 0; c < 8; ++c)
    parts.push_back(
        {.shape = box{{1, 2, 3}}, .at = {vec3(c & 1u, 2. * (c >> 1 & 1u), 3. * (c >> 2))}});
  const blocks b(parts);
  const box whole{{2, 4, 6}};
  CHECK(b.volume() == doctest::Approx(whole.volume()));
  CHECK((b.inertia() - whole.inertia()).norm() < 1e-12);
  CHECK(b.bounding_radius() == doctest::Approx(whole.bounding_radius()));
  CHECK((b.frame().position - vec3(0.5, 1, 1.5)).norm() < 1e-13);
  CHECK((b.half_extents(pose{}) - whole.half()).norm() < 1e-12);
}

TEST_CASE("a part without mass counts for contacts and bounds only") {
  using pair = union_of<sphere>;
  const pair u({{.shape = sphere{1}}, {.shape = sphere{1}, .at = {{3, 0, 0}}, .density = 0}});
  CHECK(u.volume() == doctest::Approx(4 * pi / 3));
  CHECK(u.frame().position == vec3(0, 0, 0));
  CHECK((u.inertia() - sphere{1}.inertia()).norm() < 1e-15);
  CHECK(u.bounding_radius() == doctest::Approx(4));
}

TEST_CASE("unions are shared, compared and sent by content") {
  const any_union a({{.shape = sphere{1}},
                     {.shape = convex_polyhedron({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1.5}}),
                      .at = {{1, 0, 0}}}});
  const any_union again(
      {{.shape = sphere{1}},
       {.shape = convex_polyhedron({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1.5}}),
        .at = {{1, 0, 0}}}});
  CHECK(a == any_union(a));
  CHECK(a == again);
  CHECK_FALSE(a == any_union({{.shape = sphere{1}}}));
  CHECK_FALSE(a == any_union());

  // Without a memory of the connection all data are sent; with one, once.
  detail::shared_memory here, there;
  for (int message = 0; message < 3; ++message) {
    here.next_exchange(), there.next_exchange();
    detail::byte_buffer bytes;
    detail::byte_writer out(bytes, &here);
    out.put(a);
    out.put(a);
    detail::byte_reader in(bytes, &there);
    const auto one = in.get<any_union>(), two = in.get<any_union>();
    CHECK(in.empty());
    CHECK(one == a);
    CHECK(two == a);
    CHECK(one.inertia() == a.inertia());
    CHECK(one.bounding_radius() == a.bounding_radius());
    CHECK((bytes.size() == 34) == (message > 0));
    const vec3 d = vec3(1, 2, 3);
    CHECK(one.support(d) == a.support(d));
  }
  // Entries unused for long are removed on both sides alike, and sent again.
  for (int message = 0; message < 60; ++message) here.next_exchange(), there.next_exchange();
  CHECK(here.size() == 0);
  CHECK(there.size() == 0);
  detail::byte_buffer bytes;
  detail::byte_writer out(bytes, &here);
  out.put(a);
  CHECK(bytes.size() > 34);
  detail::byte_reader in(bytes, &there);
  CHECK(in.get<any_union>() == a);
  // A name without the data is refused.
  detail::byte_buffer name_only;
  detail::byte_writer(name_only, &here).put(a);
  detail::byte_reader stranger(name_only);
  CHECK_THROWS_AS(stranger.get<any_union>(), std::runtime_error);
}

TEST_CASE("impossible unions are refused by name") {
  using pair = union_of<sphere, box>;
  CHECK(message_of([] { pair().validate(); }).find("without parts") != std::string::npos);
  CHECK(message_of([] { pair(std::vector<pair::part>{}); }).find("parts") != std::string::npos);
  CHECK(message_of([] { pair({{.shape = sphere{-1}}}); }).find("radius of a sphere") !=
        std::string::npos);
  CHECK(message_of([] { pair({{.shape = box{}, .density = -1}}); }).find("density of part 0") !=
        std::string::npos);
  CHECK(message_of([] { pair({{.shape = box{}, .density = 0}}); }).find("density 0") !=
        std::string::npos);
  CHECK(message_of([] {
          pair({{.shape = box{}, .at = {{1 / real(0), 0, 0}}}});
        }).find("part 0") != std::string::npos);
  CHECK(message_of([] {
          pair({{.shape = box{}, .at = {{0, 0, 0}, quat(1, 1, 0, 0)}}});
        }).find("unit quaternion") != std::string::npos);
}
