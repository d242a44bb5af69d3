#pragma once
// All joints of a rank, island by island.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "talus/constraint/joint_line.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/articulated_rows.hpp"
#include "talus/solver/direct/articulation.hpp"
#include "talus/solver/direct/supported_loads.hpp"

namespace talus::detail {

/// All articulations of a rank.
class articulations {
 public:
  template <class Bodies>
  void gather(std::span<const joint_view> joints, const Bodies& all) {
    all_.clear();
    if (joints.empty()) return;
    plain_vector<std::int32_t> number(all.size(), -1);
    sets_.reset(all.size());
    const auto moves = [&](std::int32_t i) { return all.inverse_mass(i) != 0; };
    for (const joint_view& x : joints)
      if (moves(x.a) && moves(x.b)) sets_.join(x.a, x.b);
    plain_vector<std::int32_t> roots;
    for (const joint_view& x : joints) {
      if (!moves(x.a) && !moves(x.b)) continue;
      const auto root = static_cast<std::int32_t>(sets_.root(moves(x.a) ? x.a : x.b));
      std::int32_t& k = number[static_cast<std::size_t>(root)];
      if (k < 0) {
        k = static_cast<std::int32_t>(all_.size());
        all_.emplace_back();
        roots.push_back(root);
      }
      all_[static_cast<std::size_t>(k)].add(x);
    }
    for (const std::int32_t root : roots) number[static_cast<std::size_t>(root)] = -1;
    for (articulation& one : all_) one.arrange(all, number);
  }
  template <class Bodies>
  void solve(Bodies&& all) {
    for (articulation& one : all_) one.solve(all);
  }
  /// After the last solve() of a step.
  void share_loads() {
    for (articulation& one : all_) one.share_loads();
  }
  /// Shares the loads after the last solve() of a step, also among the contacts of jointed bodies
  /// with what cannot move, which are sorted.
  template <class Bodies>
  void share_loads(const Bodies& all, std::span<joint_support> supports) {
    plain_vector<std::int32_t> number(all.size(), -1);
    for (articulation& one : all_) one.share_loads(all, supports, number);
  }
  [[nodiscard]] bool may_need_supports() {
    return std::any_of(all_.begin(), all_.end(),
                       [](articulation& one) { return one.may_need_supports(); });
  }
  /// The rows have changed since the last solve().
  void renew() {
    for (articulation& one : all_) one.renew();
  }
  [[nodiscard]] bool empty() const { return all_.empty(); }

 private:
  std::vector<articulation> all_;
  disjoint_sets sets_;
};

}  // namespace talus::detail
