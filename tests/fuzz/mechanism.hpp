#pragma once
// The plan of a random mechanism: its bodies, joints and events as data, drawn from a seed. Items
// have numbers, so that a smaller mechanism is a seed and the numbers of the items left out.
#include <array>
#include <limits>
#include <set>
#include <string>
#include <talus/core/math.hpp>
#include <vector>

#include "plan.hpp"

namespace fuzz {

using talus::quat;

/// A body of a mechanism, or something immovable that holds it.
struct mechanism_body {
  enum class role { movable, fixed, global, driven };
  role how = role::movable;
  bool is_box = false;
  vec3 size{0, 0, 0};  ///< edges, or the radius three times
  vec3 at{0, 0, 0};
  quat turn{1, 0, 0, 0};
  vec3 velocity{0, 0, 0}, spin{0, 0, 0};
  vec3 stroke{0, 0, 0};  ///< of a driven one: half its way, or 0 if it turns
  vec3 axis{0, 0, 1};    ///< about which it turns
  real speed = 0;        ///< cycles or radians per unit of time
};

/// What acts on an angle or a travel, with magnitudes for the mechanism at hand.
struct mechanism_axis {
  static constexpr real infinity = std::numeric_limits<real>::infinity();
  real lower = -infinity, upper = infinity, restitution = 0;
  real motor_velocity = 0, largest = 0, position = 0, stiffness = 0, damping = 0;
  real spring = 0, spring_damping = 0, rest = 0, friction = 0;
};

struct mechanism_joint {
  enum class kind {
    ball,
    fixed,
    weld,
    hinge,
    slider,
    cylindrical,
    universal,
    rod,
    rope,
    strut,
    point_on_plane,
    gear
  };
  static constexpr int world = -1;
  kind what = kind::ball;
  int a = world, b = world;  ///< bodies
  int step = 0;              ///< when it is made; 0: at the start
  real fraction = 0.5;       ///< of the way from a to b, where it is
  vec3 off{0, 0, 0};         ///< from there; the way from b to a joint with the world
  vec3 axis{0, 0, 1}, second_axis{1, 0, 0};
  mechanism_axis first, second;
  real strength = 0;     ///< of a weld
  real restitution = 0;  ///< of a rope
  real ratio = -1;       ///< of a gear
};

struct mechanism_event {
  enum class kind {
    fix,
    release,
    destroy,  ///< after the release of its joints
    part,     ///< a joint is released
    motor,    ///< a joint gets another motor
    push,     ///< a body gets another velocity
    shift,    ///< an immovable body is translated
    gravity,
    synchronize,
    restart,  ///< checkpoint, and restart on other ranks
    divide    ///< another decomposition
  };
  kind what = kind::push;
  int step = 0;
  int target = 0;  ///< body or joint; ranks of a restart
  vec3 value{0, 0, 0};
  real number = 0;
};

struct mechanism {
  enum class domains { grid, slabs, bisection, cells, hexagonal };
  std::uint64_t seed = 0;
  bool reproducible = true;  ///< else the default solver
  bool around = false;       ///< in a periodic box
  bool wild = false;         ///< may be inconsistent
  bool floor = false, sleeps = false, balances = false;
  domains how = domains::grid;
  int ranks = 1, steps = 100;
  real dt = 0.005;
  vec3 gravity{0, 0, 0};
  real friction = 0, restitution = 0;
  real side = 1;   ///< half the edge of the space that is divided
  real reach = 9;  ///< of connections
  int iterations = 5;
  std::vector<mechanism_body> bodies;
  std::vector<mechanism_joint> joints;
  std::vector<mechanism_event> events;
  std::set<int> without;  ///< numbers of items left out: bodies, then joints, then events

  [[nodiscard]] int items() const {
    return static_cast<int>(bodies.size() + joints.size() + events.size());
  }
  [[nodiscard]] bool has_body(int k) const { return k < 0 || !without.contains(k); }
  [[nodiscard]] bool has_joint(int k) const {
    const mechanism_joint& j = joints[static_cast<std::size_t>(k)];
    return !without.contains(static_cast<int>(bodies.size()) + k) && has_body(j.a) && has_body(j.b);
  }
  [[nodiscard]] bool has_event(int k) const {
    return !without.contains(static_cast<int>(bodies.size() + joints.size()) + k);
  }
};

mechanism draw_mechanism(std::uint64_t seed, bool around);
/// In words, an item a line.
std::string text(const mechanism& m);

/// A mechanism at the end of a run, and what was seen on the way.
struct mechanism_end {
  struct body {
    std::uint64_t id = 0;
    std::array<real, 13> state{};  ///< position, orientation, velocity, angular velocity
    bool operator<(const body& o) const { return id < o.id; }
  };
  std::vector<body> bodies;
  std::vector<std::array<real, 3>> joints;  ///< whether it is there, its angle and its travel
  std::vector<std::string> digests;         ///< after each step, if they were asked for
  std::string digest;
  std::string refused;  ///< the message the run ended with, if it did
  std::uint64_t contacts = 0, crossed = 0;
  real worst_closure = 0, gap = 0, fastest = 0;
  real energy = 0, gain = 0;  ///< the largest one, and what impulses add in a step, as a part of it
  real opened = 0;            ///< as the world says: the part of its arm by which a joint was open
  int step_of_gain = -1, step_of_gap = -1;
};
struct mechanism_options {
  real perturbation = 0;  ///< of the first positions
  bool trace = false;     ///< digests of all steps
};

/// A run on so many ranks. With several it is restarted on others, if the mechanism says so.
using mechanism_runner = mechanism_end (*)(const mechanism&, int ranks, const mechanism_options&);

/// Draws the mechanism of the plan, and throws `broken` if something is wrong with it.
outcome check_mechanism(const plan& p, bool around, mechanism_runner run);

}  // namespace fuzz
