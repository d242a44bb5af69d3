#pragma once
// What a benchmark scene is, without any engine: plain numbers that every engine is fed from, and a
// digest of them that each report carries, so that two figures are known to come from one scene.
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace bench {

using vec = std::array<double, 3>;

/// A free sphere: the initial state in a scene, the final one in what an engine hands back.
struct ball {
  vec position{};
  double radius = 0;
  vec velocity{};
  vec spin{};
};

/// A free box: full edge lengths, orientation as unit quaternion (w, x, y, z) from box to world,
/// spin in the world frame; the initial state in a scene, the final one in what an engine hands
/// back.
struct crate {
  vec centre{};
  vec size{1, 1, 1};
  std::array<double, 4> orientation{1, 0, 0, 0};
  vec velocity{};
  vec spin{};
  double density = 1;
};

/// A fixed plane; solid where normal . x <= offset. The normal has unit length.
struct wall {
  vec normal{0, 0, 1};
  double offset = 0;
};

/// A fixed box: full edge lengths, orientation as unit quaternion (w, x, y, z) from box to world.
struct block {
  vec centre{};
  vec size{1, 1, 1};
  std::array<double, 4> orientation{1, 0, 0, 0};
};

/// Coefficients of a *pair*; how an engine mixes materials is its adapter's business.
struct pair_law {
  double friction = 0;
  double restitution = 0;
};

struct scene {
  std::string name;
  std::vector<ball> balls;
  std::vector<ball> boulders;  ///< fixed balls
  std::vector<wall> walls;
  std::vector<block> blocks;
  std::vector<crate> crates;
  double density = 1;      ///< of the balls
  pair_law between_balls;  ///< and crates: between what moves
  pair_law against_fixed;
  double gravity = 0;  ///< acceleration along z, negative downwards
  double dt = 0;       ///< time step
};

/// Random numbers of one site of a scene (splitmix64, Steele, Lea, Flood 2014): a function of seed
/// and site alone, the same on every compiler.
class dice {
 public:
  constexpr dice(std::uint64_t seed, std::uint64_t site) : state_(mix(mix(seed) + site)) {}

  /// Uniform in [low, high). The explicit fma keeps the last bit independent of compiler flags.
  double between(double low, double high) {
    state_ += 0x9e3779b97f4a7c15u;
    return std::fma(high - low, static_cast<double>(mix(state_) >> 11) * 0x1p-53, low);
  }

  vec between(const vec& low, const vec& high) {
    vec v{};
    for (std::size_t k = 0; k < 3; ++k) v[k] = between(low[k], high[k]);
    return v;
  }

 private:
  static constexpr std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

/// FNV-1a over every number of the scene, as 16 hexadecimal digits.
inline std::string digest(const scene& s) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto eat = [&](auto... values) {
    const auto one = [&](double value) {
      auto bits = std::bit_cast<std::uint64_t>(value);
      for (int byte = 0; byte < 8; ++byte, bits >>= 8)
        hash = (hash ^ (bits & 255)) * 0x100000001b3u;
    };
    (one(values), ...);
  };
  const auto eat_all = [&](const auto& numbers) {
    for (const double x : numbers) eat(x);
  };
  for (const ball& b : s.balls)
    eat_all(b.position), eat(b.radius), eat_all(b.velocity), eat_all(b.spin);
  for (const ball& b : s.boulders) eat_all(b.position), eat(b.radius);
  for (const wall& w : s.walls) eat_all(w.normal), eat(w.offset);
  for (const block& b : s.blocks) eat_all(b.centre), eat_all(b.size), eat_all(b.orientation);
  for (const crate& c : s.crates) {
    eat_all(c.centre), eat_all(c.size), eat_all(c.orientation), eat_all(c.velocity);
    eat_all(c.spin), eat(c.density);
  }
  eat(s.density, s.between_balls.friction, s.between_balls.restitution, s.against_fixed.friction,
      s.against_fixed.restitution, s.gravity, s.dt);
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace bench
