// A shape of one's own whose support function or bounds are wrong is refused when a body with it is
// added, with the direction and the values.
#include <doctest/doctest.h>

#include <limits>
#include <string>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/convex_form.hpp>
#include <talus/shape/ellipsoid.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/shape/superellipsoid.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

int asked = 0;  ///< calls of support()

/// A ball with a mistake.
struct own {
  enum mistake {
    none,
    hollow,
    inward,
    not_a_number,
    length,
    radius,
    box,
    zero,
    off,
    no_volume,
    negative_volume,
    large_volume,
    negative_moments,
    uneven_moments,
    moments_times_mass,
    moments_of_a_grain,
    half_volume,
    moments_twice
  };
  real size = 1;
  int kind = none;

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "pebble";
  void validate() const {}
  [[nodiscard]] real bounding_radius() const { return kind == radius ? 0.9 * size : size; }
  [[nodiscard]] real volume() const {
    const real right = 4 * pi / 3 * size * size * size;
    return kind == no_volume         ? 0 * right
           : kind == negative_volume ? -right
           : kind == large_volume    ? 1.1 * right
           : kind == half_volume     ? 0.5 * right
                                     : right;
  }
  [[nodiscard]] vec3 inertia() const {
    const vec3 right = vec3(1, 1, 1) * (0.4 * size * size);
    if (kind == negative_moments) return vec3(-right[0], -right[1], right[2]);
    if (kind == uneven_moments) return vec3(0.1, 0.1, 0.9) * (size * size);
    if (kind == moments_times_mass) return 1000 * right;
    if (kind == moments_of_a_grain) return 1e-3 * right;
    if (kind == moments_twice) return 2 * right;
    return right;
  }
  [[nodiscard]] vec3 support(const vec3& direction) const {
    ++asked;
    const vec3 d = kind == length ? direction : unit(direction);
    // A dent at the top: points of the rim lie further along z.
    if (kind == hollow && d[2] > 0.9) return 0.5 * size * d;
    if (kind == inward) return -size * d;
    if (kind == not_a_number && d[0] > 0.7)
      return vec3(std::numeric_limits<real>::quiet_NaN(), 0, 0);
    if (kind == zero && !(d.norm() > 0)) return vec3(0, 0, 0) / d.norm();
    if (kind == off) return 0.1 * size * d + vec3(0, 0, 0.5 * size);
    return size * d;
  }
  [[nodiscard]] vec3 half_extents(const pose&) const {
    return vec3(size, size, kind == box ? 0.9 * size : size);
  }
  friend bool operator==(const own&, const own&) = default;
};

/// A brick that gives its faces, perhaps with a mistake.
template <bool Filled>
struct brick_of {
  enum mistake {
    none,
    no_volume,
    volume_of_half,
    moments_of_edges,
    middle_off,
    turned,
    other_form
  };
  vec3 edges{1, 2, 3};
  int kind = none;

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr bool homogeneous = Filled;
  static constexpr const char* name = Filled ? "brick" : "hollow_brick";
  void validate() const {}
  [[nodiscard]] box as_box() const { return box{edges}; }
  [[nodiscard]] real bounding_radius() const { return 2 * as_box().bounding_radius(); }
  [[nodiscard]] real volume() const {
    return as_box().volume() * (kind == no_volume ? 0 : kind == volume_of_half ? 0.125 : 1);
  }
  [[nodiscard]] vec3 inertia() const {
    return as_box().inertia() * (kind == moments_of_edges ? 3 : 1);
  }
  [[nodiscard]] quat turn() const { return rotation({0, 0, 1}, kind == turned ? 0.6 : 0); }
  [[nodiscard]] vec3 support(const vec3& d) const {
    const vec3 p = turn() * as_box().support(turn().conjugate() * d);
    return kind == middle_off ? vec3(p + vec3(0, 0, 0.3 * edges[2])) : p;
  }
  [[nodiscard]] vec3 half_extents(const pose&) const { return vec3(1, 1, 1) * bounding_radius(); }
  [[nodiscard]] block_form form() const { return {kind == other_form ? edges : edges / 2}; }
  friend bool operator==(const brick_of&, const brick_of&) = default;
};
using brick = brick_of<true>;
using hollow_brick = brick_of<false>;

using both = union_of<own, sphere>;
using scene = scenario<bodies<own, brick, hollow_brick, sphere, both, plane>, transport<serial>>;

template <class Shape>
std::string refusal(const Shape& s) {
  serial::link link;
  world<scene> w(link);
  const auto stuff = w.material({.density = 1});
  try {
    w.add(body<Shape>{.shape = s, .material = stuff});
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}
bool says(const std::string& text, const char* words) {
  INFO(text);
  CHECK(text.find(words) != std::string::npos);
  return text.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("a shape of one's own with a mistake is refused, with the direction and the values") {
  CHECK(refusal(own{}) == "");
  CHECK(refusal(own{1e-50}) == "");
  CHECK(refusal(own{1e50}) == "");
  for (const real size : {1., 1e-6}) {
    says(refusal(own{size, own::hollow}),
         "the support function of a pebble is not that of a convex body: support((");
    says(refusal(own{size, own::inward}), "so that its centre of mass, the origin, is not inside");
    says(refusal(own{size, own::not_a_number}), "of a pebble returns no point: support((");
    says(refusal(own{size, own::length}), "depends on the length of the direction: support((");
    says(refusal(own{size, own::radius}), "bounding_radius() is ");
    says(refusal(own{size, own::box}), "half_extents() of that pose returns (");
    says(refusal(own{size, own::zero}), "support((0, 0, 0)) is (");
    says(refusal(own{size, own::off}), "the origin, is not inside");
    says(refusal(own{size, own::no_volume}), "volume() of a pebble returns 0; return its volume");
    says(refusal(own{size, own::negative_volume}), "volume() of a pebble returns -4.18");
    says(refusal(own{size, own::large_volume}), "the ball of its bounding_radius()");
    says(refusal(own{size, own::negative_moments}), "each must be a finite number above 0");
    says(refusal(own{size, own::uneven_moments}), "is more than the sum");
    says(refusal(own{size, own::moments_times_mass}), "the square of its bounding_radius()");
    says(refusal(own{size, own::moments_of_a_grain}), "a hundredth of those of a ball");
    says(refusal(own{size, own::half_volume}),
         "but the body of its support function has about 4.18");
    says(refusal(own{size, own::moments_twice}),
         "but the body of its support function has about (");
  }
  says(refusal(own{1, own::hollow}), "(0, 0, 1)");
  says(refusal(own{1, own::hollow}), "at 0.");
  says(refusal(own{std::numeric_limits<real>::quiet_NaN()}),
       "bounding_radius() of a pebble returns nan");
}

TEST_CASE("a shape with faces is tested, too, and its mass against its support function") {
  CHECK(refusal(brick{}) == "");
  CHECK(refusal(brick{{1e-3, 1e-6, 1e-3}}) == "");
  for (const real size : {1., 1e-4}) {
    const vec3 edges = size * vec3(1, 2, 3);
    says(refusal(brick{edges, brick::no_volume}), "volume() of a brick returns 0");
    says(refusal(brick{edges, brick::volume_of_half}),
         "the body of its support function has about 6");
    says(refusal(brick{edges, brick::moments_of_edges}), "inertia() of a brick returns (");
    says(refusal(brick{edges, brick::middle_off}), "lies at about (");
    says(refusal(brick{edges, brick::turned}), "are not its principal axes of inertia");
    says(refusal(brick{edges, brick::other_form}), "form() of a brick reaches ");
    // The walls of a hollow one have other moments.
    CHECK(refusal(hollow_brick{edges, brick::moments_of_edges}) == "");
    says(refusal(hollow_brick{edges, brick::no_volume}), "volume() of a hollow_brick returns 0");
  }
}

TEST_CASE("parts of unions are tested, too") {
  CHECK(refusal(both({{.shape = own{}}, {.shape = sphere{0.5}}})) == "");
  says(refusal(both({{.shape = own{1, own::hollow}}, {.shape = sphere{0.5}}})),
       "the support function of a pebble is not that of a convex body");
  says(refusal(both({{.shape = own{1, own::uneven_moments}}, {.shape = sphere{0.5}}})),
       "inertia() of a pebble returns (0.1, 0.1, 0.9)");
}

TEST_CASE("many bodies of one shape are tested once, and many shapes at a bounded cost") {
  serial::link link;
  world<scene> w(link);
  const auto stuff = w.material({.density = 1});
  const own same{1.25};
  w.add(body{.shape = same, .material = stuff});
  const int first = asked;
  for (int k = 0; k < 100; ++k)
    w.add(body{.shape = same, .position = {3.0 * k, 0, 0}, .material = stuff});
  CHECK(asked == first);
  for (int k = 0; k < 1000; ++k)
    w.add(body{.shape = own{1 + 1e-3 * k}, .position = {3.0 * k, 4, 0}, .material = stuff});
  CHECK(asked - first < 64 * 500 + 8 * 40000);
}
