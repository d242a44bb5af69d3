#pragma once
// Walls that are held at a force or a pressure: what world.hold_force takes.
#include <concepts>
#include <functional>
#include <utility>

#include "talus/core/math.hpp"

namespace talus {

/// A number, or a function of the time of the world that returns one.
class number_in_time {
 public:
  number_in_time() = default;
  /// A number that does not depend on the time.
  number_in_time(real always) : always_(always), given_(true) {}
  /// A function of the time, which returns the same bits on all ranks.
  template <class F>
  requires std::is_invocable_r_v<real, const F&, real> number_in_time(F f)
      : function_(std::move(f)), given_(true) {}

  /// Whether a number or a function was given.
  [[nodiscard]] bool given() const { return given_; }
  /// Whether it is a function.
  [[nodiscard]] bool changes() const { return static_cast<bool>(function_); }
  /// The value at a time, of the number or the function.
  [[nodiscard]] real operator()(real time) const { return function_ ? function_(time) : always_; }

 private:
  real always_ = 0;
  std::function<real(real)> function_;
  bool given_ = false;
};

/// Motion of a global body so that contacts press on it with a given force, or on a plane with a
/// given pressure; see world::hold_force. Force and pressure are numbers, or functions of the time
/// of the world that return a number.
struct servo {
  number_in_time force{};     ///< that contacts exert against `axis`: mass times length over time^2
  number_in_time pressure{};  ///< instead of `force`, on the present area of a plane
  real max_speed = 0;         ///< upper limit, in both directions: length over time
  /// Direction in which the body presses; any length. Zero, the default: the normal of a plane.
  vec3 axis{0, 0, 0};
};

}  // namespace talus
