#pragma once
// A mechanism as plain numbers, without any engine: bodies, joints with world anchors, springs.
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace bench::joints {

using vec = Eigen::Vector3d;
using turn = Eigen::Quaterniond;

constexpr double pi = 3.14159265358979323846;

// Simbody's headers need C++17, so the scenes do without what came later.
inline bool begins(const std::string& text, const std::string& with) {
  return text.compare(0, with.size(), with) == 0;
}

/// Pose and velocity of a body: centre of mass, rotation from body to world, spin in the world.
struct state {
  vec position = vec::Zero();
  turn orientation = turn::Identity();
  vec velocity = vec::Zero();
  vec spin = vec::Zero();
};

/// A rigid body; `inertia` holds the principal moments about the axes of the body frame, kg m².
struct body {
  double mass = 1;
  vec inertia = vec::Ones();
  state start;
};

enum class kind { ball, hinge, slider };

constexpr int ground = -1;

/// A joint between bodies a and b; a may be `ground`. Anchor and axis are in the world at the
/// start.
struct joint {
  kind type = kind::ball;
  int a = ground;
  int b = 0;
  vec at = vec::Zero();
  vec axis = vec::UnitZ();
};

/// A spring with a damper between two points, given in the world at the start; a may be `ground`.
struct spring {
  int a = ground;
  int b = 0;
  vec at_a = vec::Zero();
  vec at_b = vec::Zero();
  double stiffness = 0;  ///< N/m
  double damping = 0;    ///< N s/m
  double rest = 0;       ///< m
};

/// A constant torque in the world frame.
struct drive {
  int on = 0;
  vec torque = vec::Zero();
};

/// A measured value: a point of a body, given in the world at the start, or a direction of a body.
struct probe {
  int of = 0;
  vec at = vec::Zero();
  bool direction = false;
};

struct scene {
  std::string name{};
  double duration = 10;  ///< s
  vec gravity{0, -9.81, 0};
  double length = 1;         ///< typical length, m, for angles of joints in the drift
  bool conservative = true;  ///< the energy of bodies and springs stays as it is
  std::vector<body> bodies{};
  std::vector<joint> joints{};
  std::vector<spring> springs{};
  std::vector<drive> drives{};
  std::vector<probe> probes{};
  std::string error_is{};
};

inline std::vector<state> start_of(const scene& s) {
  std::vector<state> states;
  for (const body& b : s.bodies) states.push_back(b.start);
  return states;
}

/// World position now of the point that was at `at` at the start.
inline vec moved_point(const scene& s, const std::vector<state>& now, int of, const vec& at) {
  if (of == ground) return at;
  const state& before = s.bodies[of].start;
  return now[of].position +
         now[of].orientation * (before.orientation.conjugate() * (at - before.position));
}

/// World direction now of what was `direction` at the start.
inline vec moved_direction(const scene& s, const std::vector<state>& now, int of,
                           const vec& direction) {
  if (of == ground) return direction;
  return now[of].orientation * (s.bodies[of].start.orientation.conjugate() * direction);
}

}  // namespace bench::joints
