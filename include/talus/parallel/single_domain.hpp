#pragma once
// The domain of a single rank: all of space, without code for connections.
#include <limits>
#include <span>
#include <utility>

#include "talus/concepts.hpp"
#include "talus/core/error.hpp"
#include "talus/parallel/connection.hpp"

namespace talus {

/// The counterpart of domain<...> for a link that never has a second rank.
class single_domain {
 public:
  static constexpr bool periodic = false;

  /// Checks the decomposition, although it is not used.
  template <concepts::decomposition Decomposition>
  single_domain(const Decomposition& d, int, int, real = 0) {
    if constexpr (concepts::generating_decomposition<Decomposition>)
      (void)d.resolve(d.size() > 0 ? d.size() : 1);
  }
  [[nodiscard]] static single_domain undivided(int, int) { return {}; }

  /// All forms of domain::connect; there is no rank to connect to: invalid_argument.
  void connect(int rank, real, real, real, real, real = 0) { refuse(rank); }
  void connect(int rank, const vec3&, real, real = 0) { refuse(rank); }
  void connect(int rank, real, real, real, real, real, real, real = 0) { refuse(rank); }
  void connect(int rank, const vec3&, const vec3&, real = 0) { refuse(rank); }
  template <concepts::polyhedral Region>
  void connect(int rank, const Region&, real = 0) {
    refuse(rank);
  }
  void disconnect(int rank) {
    detail::fail<std::invalid_argument>(
        "rank 0 is not connected to rank {}, so that it cannot disconnect: it is alone in a serial "
        "program",
        rank);
  }

  [[nodiscard]] std::span<const connection> connections() const { return {}; }
  [[nodiscard]] bool contains(const vec3& p) const { return !detail::has_nan(p); }
  [[nodiscard]] int owner(const vec3& p) const { return contains(p) ? 0 : -1; }
  [[nodiscard]] std::pair<vec3, vec3> bounds() const {
    constexpr real infinity = std::numeric_limits<real>::infinity();
    return {vec3(-infinity, -infinity, -infinity), vec3(infinity, infinity, infinity)};
  }

 private:
  single_domain() = default;
  [[noreturn]] static void refuse(int rank) {
    detail::fail<std::invalid_argument>(
        "rank 0 cannot connect to rank {}: it is alone in a serial program; choose another "
        "transport",
        rank);
  }
};

}  // namespace talus
