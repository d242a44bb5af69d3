#pragma once
// State of a world for features<balancing>; see world/balance.hpp.
#include <cmath>
#include <cstdint>
#include <limits>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"

namespace talus {

/// The quantity that domains share equally.
enum class balance_by {
  time,  ///< processor time of the steps, without exchanges; each body has the mean cost of its
         ///< rank's bodies. For thousands of bodies per rank: with few, the cost of a step without
         ///< bodies counts too
  count  ///< number of bodies: the same cuts in each run
};

/// When cuts move; see world::balance.
struct balance_settings {
  std::uint64_t every = 1000;  ///< steps between checks, which are collective
  double above = 1.2;          ///< largest share over the mean one up to which cuts stay, >= 1
  /// the quantity that is shared: number of bodies, or time
  balance_by by = balance_by::count;
};

/// Evenness of the shares of ranks: the largest share over the mean one, 1 at best.
struct imbalance {
  double bodies = 1;    ///< of the bodies owned
  double contacts = 1;  ///< of those in the last step; NaN if there were none
  double time = 1;      ///< of processor time in steps, without exchanges; NaN if not measured
};

namespace detail {

inline constexpr double unknown_share = std::numeric_limits<double>::quiet_NaN();

/// How a world with this feature divides space, and how even the shares are.
template <class Decomposition>
struct balance_state {
  balance_settings settings;
  bool moves = false;       ///< world::balance was called
  Decomposition divided;    ///< with the present cuts
  real asked = 0;           ///< reach of the connections set by the user
  real reach = 0;           ///< and the present one
  double seconds = 0;       ///< of work here since the last check
  double cost = 1;          ///< processor time of a body here, over that of the mean one
  double since_move = 0;    ///< since the last move of the cuts
  imbalance before;         ///< at the first check that moved cuts
  std::uint64_t moved = 0;  ///< number of moves of the cuts

  void divide(const Decomposition& d, real reach_asked) {
    if (moves) require_movable(d);
    divided = d;
    asked = reach = reach_asked;
  }
  static void require_movable(const Decomposition& d) {
    if constexpr (requires { d.movable(); })
      if (!d.movable())
        fail<std::invalid_argument>(
            "world.balance is to move cuts, and the decomposition that was chosen cannot: choose "
            "bisection<dynamic>");
  }
  void note_move(const imbalance& found) {
    before = {std::fmax(before.bodies, found.bodies), std::fmax(before.contacts, found.contacts),
              std::fmax(before.time, found.time)};  // NaN yields to any number
    since_move = 0;
    ++moved;
  }
  [[nodiscard]] bool due(std::uint64_t step) const { return moves && step % settings.every == 0; }
};

}  // namespace detail
}  // namespace talus
