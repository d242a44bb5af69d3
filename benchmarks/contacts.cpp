// The time of the contact of one pair, in nanoseconds of the processor, of shapes at random poses
// about to touch: spheres, capsules, superellipsoids and ellipsoids 1 : 1 : 2, by their own
// routines and by the general one for convex shapes.
#include <sys/resource.h>

#include <cstdio>
#include <random>
#include <talus/detect/narrow.hpp>
#include <vector>

using namespace talus;

namespace {

/// The same body as a shape of one's own, for which there is only the general routine.
struct own_ellipsoid {
  ellipsoid body;
  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "own_ellipsoid";
  void validate() const { body.validate(); }
  [[nodiscard]] real bounding_radius() const { return body.bounding_radius(); }
  [[nodiscard]] real volume() const { return body.volume(); }
  [[nodiscard]] vec3 inertia() const { return body.inertia(); }
  [[nodiscard]] vec3 support(const vec3& direction) const { return body.support(direction); }
  [[nodiscard]] vec3 half_extents(const pose& at) const { return body.half_extents(at); }
  friend bool operator==(const own_ellipsoid&, const own_ellipsoid&) = default;
};

double seconds() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_utime.tv_sec) +
         1e-6 * static_cast<double>(used.ru_utime.tv_usec);
}

template <class A, class B>
void measure(const char* words, const A& a, const B& b) {
  std::mt19937_64 bits(1);
  std::normal_distribution<real> bell;
  const auto turn = [&] {
    return quat(bell(bits), bell(bits), bell(bits), bell(bits)).normalized();
  };
  struct pair {
    pose a, b;
  };
  std::vector<pair> pairs;
  while (pairs.size() < 1000) {
    pair p{{{0, 0, 0}, turn()}, {{0, 0, 0}, turn()}};
    const vec3 way = vec3(bell(bits), bell(bits), bell(bits)).normalized();
    for (real far = a.bounding_radius() + b.bounding_radius(); far > 0; far -= 0.002) {
      p.b.position = far * way;
      bool touch = false;
      collide_pair(a, p.a, b, p.b, 0.005, [&](const contact_geometry& g) { touch |= g.gap < 0; });
      if (touch) break;
    }
    pairs.push_back(p);
  }
  real sum = 0;
  const int rounds = 400;
  const double start = seconds();
  for (int k = 0; k < rounds; ++k)
    for (const pair& p : pairs)
      collide_pair(a, p.a, b, p.b, 0.005, [&](const contact_geometry& g) { sum += g.gap; });
  const double each = (seconds() - start) / (rounds * static_cast<double>(pairs.size()));
  std::printf("%-40s %8.1f ns   (mean gap %.2g)\n", words, 1e9 * each,
              sum / (rounds * static_cast<double>(pairs.size())));
}

}  // namespace

int main() {
  const sphere ball{0.5};
  const capsule rod{0.4, 0.8};
  const ellipsoid egg{{0.4, 0.4, 0.8}};
  const own_ellipsoid own{egg};
  measure("two spheres", ball, ball);
  measure("two capsules", rod, rod);
  measure("two ellipsoids", egg, egg);
  measure("two ellipsoids, general routine", own, own);
  const superellipsoid block{{0.4, 0.4, 0.8}, 4, 4};
  measure("two superellipsoids", block, block);
  measure("superellipsoid and sphere", block, ball);
  measure("ellipsoid and sphere", egg, ball);
  measure("ellipsoid and capsule, general routine", egg, rod);
  measure("ellipsoid and box, general routine", egg, box{{1, 1, 1}});
}
