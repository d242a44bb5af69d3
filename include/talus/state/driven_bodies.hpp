#pragma once
// State of a world for features<driven>; see features/driven/driven.hpp.
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "talus/body/motion.hpp"
#include "talus/body/servo.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/state/speed_leap.hpp"

namespace talus {

namespace detail {

/// The position of the reference point of a driven body, and its rotation since it was driven.
struct rigid_place {
  vec3 point{0, 0, 0};
  quat turn{1, 0, 0, 0};

  friend bool operator==(const rigid_place& a, const rigid_place& b) {
    return a.point == b.point && a.turn.coeffs() == b.turn.coeffs();
  }
};

/// State that does not follow from a function of time; checkpoints hold it.
struct driven_state {
  vec3 origin{0, 0, 0};  ///< the position of the body when it was driven, and its orientation
  quat orientation{1, 0, 0, 0};
  vec3 normal{0, 0, 1};  ///< likewise, of a plane
  real offset = 0;
  real since = 0;  ///< its motion counts the time from then on
  rigid_place at;
  vec3 v{0, 0, 0}, w{0, 0, 0};  ///< in the last step
  real force = 0;               ///< of a servo: of its contacts in the last step
  real speed = 0;               ///< likewise: along its axis
  real mass = 0;                ///< likewise: as a piston; 0 before it touches a body
  bool begun = false;           ///< a step has been taken
};

/// A step of a driven body: its final pose, and the velocity that contacts use.
struct driven_step {
  rigid_place end;
  vec3 v{0, 0, 0}, w{0, 0, 0};
  bool goes_on = true;    ///< it begins at the pose of the body, or nearly so
  bool too_fast = false;  ///< it rotates by half a turn or more
};

/// Sums over the contact partners of a servo, from which its force and its mass as a piston follow.
struct servo_sums {
  signed_sum force, momentum, shift;
  exact_sum mass;
};

struct driven_body {
  system_id id = no_id;
  driven_state state;
  std::function<driven_step(const driven_state&, real time, real dt)> plan;  ///< empty: it stays
  servo holds;     ///< with an axis of length one
  real force = 0;  ///< that it holds in the step under way
  bool is_servo = false;
  bool followed = false;          ///< this run has made a step with it
  vec3 from{0, 0, 0};             ///< its position at the start of the step under way
  servo_sums sums;                ///< of the step under way
  driven_step next;               ///< the step under way
  vec3 dv{0, 0, 0}, dw{0, 0, 0};  ///< change of the velocity since the last one
  // Since the last pair search:
  vec3 searched_at{0, 0, 0};       ///< its position
  quat searched_turn{1, 0, 0, 0};  ///< its orientation, if it is a surface that follows_turns
  real skin = 0;                   ///< and the reach of the search; see give_skins()
};

/// `Shapes` is the number of shapes, planes included.
template <std::size_t Shapes>
struct driven_bodies {
  std::vector<std::unique_ptr<driven_body>> all;
  /// Number in `all` of each global body of a shape, or -1.
  std::array<plain_vector<std::int32_t>, Shapes> numbers;
  std::size_t listed = 0;  ///< how many of `all` have an index there
  /// Immovable bodies come last in the solver's arrays: resting ones, one for each of `all`, and
  /// the bodies that contacts with rotating ones use.
  std::size_t first = 0;
  plain_vector<std::int32_t> owners;  ///< index in `all` of each of them, or -1
  real fastest = 0;                   ///< of finite driven bodies, in the step under way
  bool moves = false;                 ///< whether any driven body does in it
  speed_leap leap;                    ///< the largest of bodies of this rank
  driven_jump jump;                   ///< the longest, the same on all ranks
};

}  // namespace detail
}  // namespace talus
