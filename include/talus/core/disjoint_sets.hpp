#pragma once
// Disjoint sets of the numbers from 0, of which any two can be joined: islands of bodies that
// contacts connect.
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Union-find with path halving (Tarjan and van Leeuwen, Worst-case analysis of set union
/// algorithms, 1984).
class disjoint_sets {
 public:
  disjoint_sets() = default;
  explicit disjoint_sets(std::size_t n) { reset(n); }

  /// n sets of one number each.
  void reset(std::size_t n) {
    parent_.resize(n);
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }
  [[nodiscard]] std::size_t size() const { return parent_.size(); }
  [[nodiscard]] std::size_t bytes() const { return parent_.capacity() * sizeof(std::uint32_t); }

  /// The number that represents the set of i; shortens the path to it. Signed numbers are at least
  /// 0.
  template <class Number>
  [[nodiscard]] std::uint32_t root(Number of) {
    auto i = static_cast<std::uint32_t>(of);
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// One step towards it: the number itself after shorten(), until sets are joined.
  [[nodiscard]] std::uint32_t parent(std::size_t i) const { return parent_[i]; }
  /// Shortens all paths to one step, if join() had no order of its own.
  void shorten() {
    for (std::uint32_t& parent : parent_) parent = parent_[parent];  // roots come first
  }
  /// Joins the sets of a and b. The lowest number of a set represents it: each number follows its
  /// parent (the algorithm of Rem with splicing; Patwary, Blair, Manne 2010).
  template <class Number>
  void join(Number of_a, Number of_b) {
    auto a = static_cast<std::uint32_t>(of_a), b = static_cast<std::uint32_t>(of_b);
    while (parent_[a] != parent_[b]) {
      if (parent_[a] < parent_[b]) std::swap(a, b);
      const std::uint32_t next = std::exchange(parent_[a], parent_[b]);
      if (next == a) return;
      a = next;
    }
  }
  /// The root that comes first, as `before` says, represents both.
  template <class Number, class Before>
  void join(Number a, Number b, Before&& before) {
    std::uint32_t first = root(a), other = root(b);
    if (first == other) return;
    if (before(other, first)) std::swap(first, other);
    parent_[other] = first;
  }

 private:
  plain_vector<std::uint32_t> parent_;
};

}  // namespace talus::detail
