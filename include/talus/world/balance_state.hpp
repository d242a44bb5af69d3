#pragma once
// What a world keeps for features<balancing>; see world/balance.hpp.
#include <cmath>
#include <cstdint>
#include <limits>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"

namespace talus {

/// What domains are to have in equal shares.
enum class balance_by {
  time,  ///< processor time of the steps, without exchanges; a body counts for what its rank's
         ///< take. For thousands of bodies per rank: with few, what a step costs without bodies
         ///< counts too
  count  ///< bodies: the same cuts in each run
};

/// When cuts move; see world::balance.
struct balance_settings {
  std::uint64_t every = 1000;  ///< steps from one look to the next, which is collective
  double above = 1.2;          ///< largest share over the mean one up to which cuts stay, >= 1
  /// what a share is: of bodies, or of time
  balance_by by = balance_by::count;
};

/// How evenly ranks share: the largest share over the mean one, 1 at best.
struct imbalance {
  double bodies = 1;    ///< of the bodies owned
  double contacts = 1;  ///< of those in the last step; NaN where there were none
  double time = 1;      ///< of processor time in the steps, without exchanges; NaN without any
};

namespace detail {

inline constexpr double unknown_share = std::numeric_limits<double>::quiet_NaN();

/// How a world with this feature shares out space, and how even that is.
template <class Decomposition>
struct balance_state {
  balance_settings settings;
  bool moves = false;       ///< world::balance was called
  Decomposition divided;    ///< with the cuts as they are
  real asked = 0;           ///< reach of the connections, as the user wants it
  real reach = 0;           ///< and as it is
  double seconds = 0;       ///< of work here since the last look
  double cost = 1;          ///< time that a body here takes, over that of the mean one
  double since_move = 0;    ///< since cuts were moved last
  imbalance before;         ///< when cuts were to be moved for the first time
  std::uint64_t moved = 0;  ///< how often they were

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
