// Manifolds of boxes that are computed eight at a time: equal to those of single pairs.
#include <doctest/doctest.h>

#include <random>
#include <talus/detect/pairs/box_box.hpp>
#include <vector>

using namespace talus;
using namespace talus::detail;

namespace {

struct two {
  box a, b;
  pose at_a, at_b;
};
using found = std::vector<contact_geometry>;

class pairs_of_boxes {
 public:
  real between(real low, real high) { return std::uniform_real_distribution<>(low, high)(random_); }
  vec3 vector(real size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  quat turn(real size) {
    const vec3 w = vector(size);
    return quat(1, w[0], w[1], w[2]).normalized();
  }
  vec3 edges() { return {between(0.6, 1), between(0.6, 1), between(0.6, 1)}; }

  /// Boxes of any orientation about as far from each other as they are large.
  two any() {
    two x{box{edges()}, box{edges()}, {vector(1), turn(3)}, {{}, turn(3)}};
    x.at_b.position = x.at_a.position + between(0.6, 1.2) * vector(1).normalized();
    return x;
  }
  /// One on the other, rotated from flush by about `angle`.
  two stacked(real angle, bool equal) {
    two x{box{equal ? vec3(1, 1, 1) : edges()},
          box{equal ? vec3(1, 1, 1) : edges()},
          {vector(1), turn(3)},
          {}};
    const int axis = static_cast<int>(between(0, 3)), u = (axis + 1) % 3, v = (axis + 2) % 3;
    vec3 away{0, 0, 0};
    away[axis] = x.a.half()[axis] + x.b.half()[axis] + between(-3, 3) * angle;
    if (between(0, 1) < 0.5) away = -away;
    away[u] = equal ? angle * between(-1, 1) : between(-0.5, 0.5);
    away[v] = between(0, 1) < 0.5 ? angle * between(-1, 1) : between(-0.9, 0.9);
    x.at_b.position = x.at_a.position + x.at_a.orientation * away;
    x.at_b.orientation = x.at_a.orientation * turn(angle);
    return x;
  }

 private:
  std::mt19937_64 random_{7};
};

/// Results of eight pairs together; `good` counts those whose manifolds were found so.
std::vector<found> together(const std::vector<two>& pairs, real margin, int& good) {
  box_batch<real> batch;
  std::vector<box_place<real>> a, b;
  a.reserve(8), b.reserve(8);  // the batch refers to them
  for (unsigned k = 0; k < 8; ++k) {
    a.push_back(place_of<real>(pairs[k].a, pairs[k].at_a));
    b.push_back(place_of<real>(pairs[k].b, pairs[k].at_b));
    batch.set(k, a[k], b[k], margin);
  }
  const unsigned near = batch.test();
  batch.find_patches();
  std::vector<found> all(8);
  for (unsigned k = 0; k < 8; ++k)
    if (near >> k & 1u) {
      good += batch.patches().good(k);
      collide_lane(a[k], b[k], batch, k, margin,
                   [&](const contact_geometry& g) { all[k].push_back(g); });
    }
  return all;
}
found alone(const two& pair, real margin) {
  found all;
  collide(pair.a, pair.at_a, pair.b, pair.at_b, margin,
          [&](const contact_geometry& g) { all.push_back(g); });
  return all;
}
/// Largest distance of points, or 1 if the contacts differ.
real difference(const found& x, const found& y) {
  if (x.size() != y.size()) return 1;
  real largest = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (x[k].feature != y[k].feature || (x[k].normal - y[k].normal).norm() > 1e-12) return 1;
    largest = std::max({largest, (x[k].point - y[k].point).norm(), std::abs(x[k].gap - y[k].gap)});
  }
  return largest;
}
/// The largest distance of a point of the one to the nearest of the other.
real apart(const found& x, const found& y) {
  real largest = 0;
  for (const auto* from : {&x, &y})
    for (const contact_geometry& c : *from) {
      real least = 1;
      for (const contact_geometry& o : from == &x ? y : x)
        least = std::min(least, (c.point - o.point).norm());
      largest = std::max(largest, least);
    }
  return largest;
}
struct tally {
  int pairs = 0, touching = 0, good = 0, other = 0;
  int far = 0;       ///< of the others: points farther from each other than 3e-3
  real largest = 0;  ///< difference of the rest
};
template <class Make>
tally compare(int batches, real margin, Make&& make) {
  tally t;
  for (int n = 0; n < batches; ++n) {
    std::vector<two> pairs;
    for (int k = 0; k < 8; ++k) pairs.push_back(make());
    const auto found = together(pairs, margin, t.good);
    for (std::size_t k = 0; k < 8; ++k) {
      const auto one = alone(pairs[k], margin);
      ++t.pairs, t.touching += !one.empty();
      const real d = difference(found[k], one);
      if (d > 1e-9)
        ++t.other, t.far += apart(found[k], one) > 3e-3;
      else
        t.largest = std::max(t.largest, d);
    }
  }
  return t;
}

}  // namespace

TEST_CASE("patches of boxes of any orientation are the same to round-off") {
  pairs_of_boxes random;
  const auto t = compare(20000, 0.02, [&] { return random.any(); });
  CHECK(t.touching > 20000);
  CHECK(t.good > t.touching / 2);
  CHECK(t.far == 0);
  CHECK(t.other <= t.touching / 1000);
  CHECK(t.largest < 1e-12);
}

TEST_CASE("patches of boxes that are nearly flush are the same to round-off") {
  for (const bool equal : {false, true})
    for (const real angle : {0.0, 1e-12, 1e-8, 1e-5, 1e-3, 1e-2}) {
      CAPTURE(equal);
      CAPTURE(angle);
      pairs_of_boxes random;
      const auto t = compare(2000, 0.02, [&] { return random.stacked(angle, equal); });
      CHECK(t.touching > 10000);
      CHECK(t.good > t.touching / 4);
      CHECK(t.far == 0);
      CHECK(t.other <= t.touching / 1000);
      CHECK(t.largest < 1e-12);
    }
}
