#pragma once
// Candidate pairs of the last search; see pairs/neighbour_list.hpp.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "talus/contact/place.hpp"
#include "talus/core/id.hpp"
#include "talus/core/id_table.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// The recorded surroundings of a body are valid while the body moves by at most this fraction of
/// its bounding radius, or of the mean radius if that is less; and by at most its motion in some
/// steps, so that a few fast bodies do not force a search in every step.
inline constexpr real skin_part = 0.1;
inline constexpr int skin_steps = 8;

[[nodiscard]] inline real skin_of(real radius, real mean, real speed, real dt) {
  return skin_part * std::min(mean, radius) + std::min(skin_steps * dt * speed, radius);
}

/// The position of a body at its last search, and the reach of that search.
struct noted_body {
  system_id id = no_id;
  vec3 position{0, 0, 0};
  real reach = 0;  ///< including its skin

  /// Whether the found pairs are complete for a body with this reach.
  [[nodiscard]] bool covers(system_id now, const vec3& p, real reach_now) const {
    const real left = reach - reach_now;
    return id == now && left >= 0 && (p - position).squaredNorm() <= left * left;
  }
};

inline constexpr std::uint32_t nobody = 0xffffffffu;

/// The previous indices of bodies, or `nobody`; most are unchanged.
[[nodiscard]] inline plain_vector<std::uint32_t> numbers_before(
    const plain_vector<noted_body>& before, std::span<const system_id> now) {
  plain_vector<plain_pair<system_id, std::uint32_t>> others;  // and their numbers before
  const auto stayed = [&](std::size_t i) {
    return i < before.size() && i < now.size() && before[i].id == now[i];
  };
  for (std::size_t i = 0; i < before.size(); ++i)
    if (!stayed(i)) others.emplace_back(before[i].id, static_cast<std::uint32_t>(i));
  const id_table places(others, [](const auto& one) { return one.first; });
  plain_vector<std::uint32_t> was(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    was[i] = static_cast<std::uint32_t>(i);
    if (stayed(i)) continue;
    const auto at = places.find(now[i]);
    was[i] = at == id_table::unknown ? nobody : others[at].second;
  }
  return was;
}
/// The reverse: the present index of each of `count` bodies.
[[nodiscard]] inline plain_vector<std::uint32_t> numbers_now(const plain_vector<std::uint32_t>& was,
                                                             std::size_t count) {
  plain_vector<std::uint32_t> now(count, nobody);
  for (std::size_t i = 0; i < was.size(); ++i)
    if (was[i] != nobody) now[was[i]] = static_cast<std::uint32_t>(i);
  return now;
}

struct close_pair {
  std::uint32_t i, j;  ///< indices into the bodies of two shapes
  history_place last;  ///< where the history stores the last step's values of their contacts
};

/// Pairs of spheres of the last search whose contacts are kept from step to step; see
/// step/kept_contacts.hpp.
struct kept_contacts {
  plain_vector<plain_pair<std::uint32_t, std::uint32_t>> apart;  ///< pairs without a contact
  plain_vector<char> moves;                                      ///< which bodies can move
  std::uint64_t materials = 0;                                   ///< revision of the table
  std::uint64_t search = 0;                                      ///< see candidate_pairs::searches
  bool rebounds = false, slides = false;  ///< conditions depend on the velocities
  int failures = 0;  ///< steps in a row in which pairs of contacts by colours had changed
  int pause = 0;     ///< steps in which these are not kept
};

/// One list for each pair of shapes, and the positions of the bodies of each shape at the search.
struct candidate_pairs {
  struct shape {
    plain_vector<noted_body> bodies;
    std::size_t locals = 0;  ///< the first so many are owned here
  };
  std::vector<plain_vector<close_pair>> lists;
  std::vector<shape> shapes;
  bool known = false;
  int steps = 0;               ///< for which they have been valid
  int failures = 0;            ///< searches in a row that were valid for less than two steps
  int pause = 0;               ///< steps without a kept neighbour list: bodies move too fast
  std::uint64_t searches = 0;  ///< so far, and renumberings
  kept_contacts kept;

  /// The history has been written anew: contacts are found by key in the next step.
  void forget_places() {
    for (auto& list : lists)
      for (close_pair& pair : list) pair.last = history_place::unknown;
  }
  [[nodiscard]] std::size_t bytes() const {
    std::size_t sum = 0;
    for (const shape& s : shapes) sum += s.bodies.capacity() * sizeof(noted_body);
    for (const auto& list : lists) sum += list.capacity() * sizeof(close_pair);
    sum += kept.apart.capacity() * sizeof(kept.apart[0]) + kept.moves.capacity();
    return sum;
  }
};

}  // namespace talus::detail
