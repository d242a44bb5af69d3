// What every finite shape must keep: support, bounds, volume and inertia tell of one and the same
// body. A new shape joins by one line at the end.
#include <doctest/doctest.h>

#include <random>

#include "talus/concepts.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/sphere.hpp"

namespace {

using namespace talus;

static_assert(concepts::finite_shape<sphere> && concepts::finite_shape<box>);
static_assert(concepts::shape<plane> && !concepts::finite_shape<plane>);
static_assert(!concepts::shape<int> && !concepts::shape<vec3>);
static_assert(sphere::round && !box::round);

struct generator {
  std::mt19937_64 engine;
  real operator()(real low, real high) {
    return low + (high - low) * real(engine() >> 11) * 0x1p-53;
  }
  vec3 point(const vec3& half) {
    const real x = (*this)(-1, 1), y = (*this)(-1, 1), z = (*this)(-1, 1);
    return vec3(x, y, z).cwiseProduct(half);
  }
  vec3 direction() {
    for (;;) {
      const vec3 v = point({1, 1, 1});
      if (v.squaredNorm() < 1 && v.squaredNorm() > 1e-3) return v.normalized();
    }
  }
  pose place() { return {point({9, 9, 9}), rotation(direction(), (*this)(0, 2 * pi))}; }
};

// Directions from which the shape is cut out again: a point is inside if no support plane has it
// in front. Only as fine as the directions, which the tolerance allows for.
template <class Shape, class Inside>
void check_laws(const Shape& s, Inside inside, std::uint64_t seed) {
  INFO(std::string(Shape::name) << ", seed " << seed);
  generator random{std::mt19937_64(seed)};
  CHECK_NOTHROW(s.validate());
  CHECK(s == Shape(s));

  real furthest = 0;
  for (int k = 0; k < 500; ++k) {
    const vec3 d = random.direction();
    const vec3 p = s.support(d);
    INFO("direction " << d[0] << " " << d[1] << " " << d[2]);
    CHECK(inside(p * (1 - 1e-12)));
    CHECK_FALSE(inside(p * (1 + 1e-9)));
    CHECK(p.norm() <= s.bounding_radius() * (1 + 1e-12));
    CHECK((s.support(1000 * d) - p).norm() <= 1e-12 * s.bounding_radius());
    CHECK((s.support(1e-200 * d) - p).norm() <= 1e-12 * s.bounding_radius());
    for (int m = 0; m < 20; ++m) CHECK(d.dot(s.support(random.direction())) <= d.dot(p) + 1e-12);
    furthest = std::max(furthest, p.norm());
  }
  CHECK(furthest > s.bounding_radius() * 0.999);

  for (int k = 0; k < 50; ++k) {
    const pose at = random.place();
    const vec3 half = s.half_extents(at);
    for (int axis = 0; axis < 3; ++axis)
      for (const real sign : {-1., 1.}) {
        const vec3 d = at.orientation.conjugate() * vec3(sign * vec3::Unit(axis));
        CHECK((at.orientation * s.support(d))[axis] * sign == doctest::Approx(half[axis]));
      }
  }

  // Volume and moments by jittered sampling of the bounding box.
  const vec3 half = s.half_extents(pose{});
  const int n = 60;
  real count = 0;
  vec3 centre = vec3::Zero(), square = vec3::Zero(), mixed = vec3::Zero();
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const vec3 p =
            (vec3(x + random(0, 1), y + random(0, 1), z + random(0, 1)) * (2. / n) - vec3(1, 1, 1))
                .cwiseProduct(half);
        if (!inside(p)) continue;
        count += 1;
        centre += p;
        square += p.cwiseProduct(p);
        mixed += vec3(p[1] * p[2], p[2] * p[0], p[0] * p[1]);
      }
  const real volume = 8 * half.prod() * count / (real(n) * n * n);
  CHECK(volume == doctest::Approx(s.volume()).epsilon(2e-3));
  const vec3 m = square / count;
  const vec3 inertia = s.inertia();
  for (int i = 0; i < 3; ++i) {
    CHECK(inertia[i] == doctest::Approx(m[(i + 1) % 3] + m[(i + 2) % 3]).epsilon(3e-3));
    CHECK(std::abs(centre[i] / count) < 1e-3 * s.bounding_radius());
    CHECK(std::abs(mixed[i] / count) < 1e-3 * s.bounding_radius() * s.bounding_radius());
    if (Shape::round) CHECK(inertia[i] == inertia[0]);
  }
}

template <class Shape>
void check_refused(const Shape& s, const char* what) {
  try {
    s.validate();
    FAIL("accepted");
  } catch (const std::invalid_argument& error) {
    INFO(std::string(error.what()));
    CHECK(std::string(error.what()).find(what) != std::string::npos);
  }
}

const real nan_ = std::numeric_limits<real>::quiet_NaN(), inf_ = 1 / real(0);

}  // namespace

TEST_CASE("support, bounds, volume and inertia of a shape agree") {
  for (const real r : {0.3, 1., 70.})
    check_laws(
        sphere{.radius = r}, [r](const vec3& p) { return p.norm() <= r; }, 1);
  for (const vec3& size : {vec3(1, 1, 1), vec3(4.7, 2.3, 1.9), vec3(0.1, 3, 20)}) {
    const auto inside = [&](const vec3& p) {
      return ((2 * p).cwiseAbs().array() <= size.array()).all();
    };
    check_laws(box{.size = size}, inside, 2);
  }
}

TEST_CASE("a plane is solid below, its normal of any length") {
  CHECK(plane{.normal = {0, 0, 5}, .offset = 2}.distance({7, 8, 3}) == 1);
  CHECK(plane{.normal = {1e-300, 0, 0}, .offset = 2}.distance({7, 8, 3}) == 5);
  CHECK(plane{.normal = {0, -1e300, 0}, .offset = -2}.distance({7, 8, 3}) == -6);
  const vec3 n = vec3(1, 2, 3).normalized();
  CHECK(plane{.normal = n}.unit_normal() == n);
}

TEST_CASE("impossible shapes are refused by name") {
  for (const real r : {0., -1., nan_, inf_}) {
    check_refused(sphere{r}, "radius of a sphere");
    check_refused(box{{r, 1, 1}}, "x edge of a box");
    check_refused(box{{1, r, 1}}, "y edge of a box");
    check_refused(box{{1, 1, r}}, "z edge of a box");
  }
  check_refused(plane{{0, 0, 0}, 0}, "normal of a plane");
  check_refused(plane{{0, nan_, 1}, 0}, "normal of a plane");
  check_refused(plane{{0, inf_, 1}, 0}, "normal of a plane");
  check_refused(plane{{0, 0, 1}, nan_}, "offset of a plane");
  CHECK_NOTHROW(plane{}.validate());
}
