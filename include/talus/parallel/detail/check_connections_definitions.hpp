#pragma once
// The definitions of check_connections.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/detail/check_connections.hpp"

namespace talus::detail {

TALUS_INLINE bool known(const std::vector<connection_flaw>& flaws, const connection_flaw& f) {
  return std::any_of(flaws.begin(), flaws.end(), [&](const connection_flaw& g) {
    return g.kind == f.kind && std::min(g.rank, g.other) == std::min(f.rank, f.other) &&
           std::max(g.rank, g.other) == std::max(f.rank, f.other);
  });
}

TALUS_INLINE std::string summary(const std::vector<connection_flaw>& flaws) {
  constexpr std::size_t most = 10;
  std::string text = "the domains of the ranks do not fit together:";
  for (std::size_t i = 0; i < std::min(most, flaws.size()); ++i) text += "\n- " + flaws[i].message;
  if (flaws.size() > most) text += compose("\n- and {} more", flaws.size() - most);
  return text;
}

TALUS_INLINE int hand_rule::owner(int rank, const vec3& p) const {
  const int claimed = claimant(all[rank], p);
  return claimed < 0 ? rank : claimed;
}

}  // namespace talus::detail
