#pragma once
// What decides whether an island is solved exactly by solvers by colours.
#include <algorithm>
#include <cstdint>
#include <limits>

#include "talus/constraint/island_limits.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// Figures of an island, or of a part of it, which are the same for any order and any domains. A
/// sweep removes one part in (row² * ratio of masses) of the error, if so many contacts are in a
/// row, or more: where no body overloads light ones, the last two sweeps show how much.
struct stalled_figures {
  static constexpr real unknown = std::numeric_limits<real>::infinity();

  bool left_out = false;                   ///< too large, or with joints: sweeps alone solve it
  bool overloaded = false;                 ///< may contain a cluster of a heavy body on light ones
  std::uint32_t contacts = 0, bodies = 0;  ///< each contact counts on the rank of its body a
  std::uint32_t in_a_row = 0;              ///< bodies, at most: the sum over the parts
  real least_mass = std::numeric_limits<real>::max(), most_mass = 0;
  /// The largest changes of velocity in the last sweep, and in that before.
  real change = 0, change_before = 0;

  void add_mass(real mass) {
    least_mass = std::min(least_mass, mass), most_mass = std::max(most_mass, mass);
  }
  /// Whether sweeps alone solve the island, whatever its other parts are.
  [[nodiscard]] bool is_left_out(const island_limits& limits) const {
    return left_out || contacts > limits.contacts || change == unknown;
  }
  void add(const stalled_figures& other) {
    left_out |= other.left_out, overloaded |= other.overloaded;
    contacts += other.contacts, bodies += other.bodies, in_a_row += other.in_a_row;
    least_mass = std::min(least_mass, other.least_mass);
    most_mass = std::max(most_mass, other.most_mass);
    change = std::max(change, other.change);
    change_before = std::max(change_before, other.change_before);
  }
  /// Whether it is so long and narrow that sweeps fail.
  [[nodiscard]] bool is_narrow(real row) const {
    return static_cast<real>(bodies) <= abreast * row && sweeps(row) > too_many_sweeps;
  }
  /// Whether it may be: a row begins and ends at contacts with what cannot move.
  [[nodiscard]] bool may_be_narrow() const { return is_narrow(longest_row()); }
  /// Sweeps that a solution replaces.
  [[nodiscard]] real sweeps(real row) const {
    const real all = row * row * most_mass / least_mass;
    if (overloaded || !(change < change_before)) return all;
    if (change_before == unknown) return all;
    return std::min(all, change / (change_before - change));
  }
  /// Whether sweeps leave a relevant error, where gravity adds `speed` in a step; `precision` is
  /// the part of it that a sweep changes by round-off.
  [[nodiscard]] bool stalls(real row, real speed, real precision) const {
    return change < unknown && change > precision * speed && change * sweeps(row) > let_be * speed;
  }
  /// Whether the island may be solved: it is, if that holds with its known row and clusters.
  [[nodiscard]] bool may_stall(real speed, real precision, const island_limits& limits) const {
    return !left_out && contacts <= (overloaded ? limits.contacts : limits.many) &&
           (overloaded || may_be_narrow()) && stalls(longest_row(), speed, precision);
  }

 private:
  static constexpr real abreast = 4;  ///< bodies beside each other
  /// Sweeps that would remove the error, of which those of a step are a small part.
  static constexpr real too_many_sweeps = 100;
  static constexpr real let_be = 0.1;  ///< of the gain by gravity in a step

  [[nodiscard]] real longest_row() const {
    return static_cast<real>(std::min(bodies, in_a_row)) + 2;
  }
};

}  // namespace talus::detail
