#pragma once
// The decomposition without generated connections: the user makes every connection.
namespace talus {

/// Each rank describes its neighbours by connect(). It owns the points that no connected rank
/// claims.
struct by_hand {
  struct nothing {};
  [[nodiscard]] int size() const { return 0; }
  [[nodiscard]] nothing resolve(int) const { return {}; }
};

}  // namespace talus
