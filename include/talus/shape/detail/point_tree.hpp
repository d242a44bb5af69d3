#pragma once
// A tree of bounding boxes over points that avoids testing every point in searches for the furthest
// along a direction, those beyond a plane, those near a point.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

template <class Real>
class point_tree {
  using vector = vector3<Real>;

 public:
  explicit point_tree(const plain_vector<vector>& points) : points_(points) {
    for (std::uint32_t i = 0; i < points.size(); ++i) order_.push_back(i);
    if (!points.empty()) build(0, static_cast<std::uint32_t>(points.size()));
  }

  /// Calls f(i) for the points with direction . (point - from) >= least.
  template <class F>
  void each_beyond(const vector& direction, const vector& from, Real least, F&& f) const {
    each_in([&](const node& n) { return highest(n, direction, from) >= least; },
            [&](std::uint32_t i) {
              if (direction.dot(points_[i] - from) >= least) f(i);
            });
  }
  /// Calls f(i) for the points within `distance`, and may for some that are further away.
  template <class F>
  void each_near(const vector& from, Real distance, F&& f) const {
    each_in(
        [&](const node& n) {
          for (int k = 0; k < 3; ++k)
            if (from[k] < n.lower[k] - distance || from[k] > n.upper[k] + distance) return false;
          return true;
        },
        f);
  }
  /// The largest value of height(i), which may exceed direction . (point - from) by `slack`.
  /// Calls height(i) only for points that may be higher than the highest found before.
  template <class Height>
  void find_highest(const vector& direction, const vector& from, Real slack, Real& best,
                    Height&& height) const {
    if (nodes_.empty()) return;
    std::array<std::uint32_t, 64> waiting;
    int count = 0;
    waiting[0] = 0, count = 1;
    while (count > 0) {
      const node& n = nodes_[waiting[--count]];
      if (!(highest(n, direction, from) + slack > best)) continue;
      if (n.right == 0) {
        for (auto k = n.begin; k < n.end; ++k) best = std::max(best, height(order_[k]));
        continue;
      }
      const auto left = static_cast<std::uint32_t>(&n - nodes_.data()) + 1;
      const bool first =
          highest(nodes_[left], direction, from) >= highest(nodes_[n.right], direction, from);
      waiting[count++] = first ? n.right : left;
      waiting[count++] = first ? left : n.right;
    }
  }
  /// The largest direction . point.
  [[nodiscard]] Real furthest(const vector& direction) const {
    Real best = -std::numeric_limits<Real>::infinity();
    find_highest(direction, vector::Zero(), 0, best,
                 [&](std::uint32_t i) { return direction.dot(points_[i]); });
    return best;
  }

 private:
  static constexpr std::uint32_t leaf = 8;
  struct node {
    vector lower, upper;
    std::uint32_t begin = 0, end = 0;
    std::uint32_t right = 0;  ///< the second child, the first being the next node; 0: a leaf
  };

  template <class Enter, class F>
  void each_in(Enter&& enter, F&& f) const {
    if (nodes_.empty()) return;
    std::array<std::uint32_t, 64> waiting;
    int count = 0;
    waiting[0] = 0, count = 1;
    while (count > 0) {
      const node& n = nodes_[waiting[--count]];
      if (!enter(n)) continue;
      if (n.right == 0) {
        for (auto k = n.begin; k < n.end; ++k) f(order_[k]);
        continue;
      }
      waiting[count++] = n.right;
      waiting[count++] = static_cast<std::uint32_t>(&n - nodes_.data()) + 1;
    }
  }
  /// At least direction . (point - from) of every point in the node: the same sum of larger terms.
  [[nodiscard]] static Real highest(const node& n, const vector& direction, const vector& from) {
    Real sum = 0;
    for (int k = 0; k < 3; ++k)
      sum += direction[k] * ((direction[k] < 0 ? n.lower[k] : n.upper[k]) - from[k]);
    return sum;
  }
  void build(std::uint32_t begin, std::uint32_t end) {
    node made{points_[order_[begin]], points_[order_[begin]], begin, end};
    for (auto k = begin; k < end; ++k) {
      made.lower = lower_of(made.lower, points_[order_[k]]);
      made.upper = upper_of(made.upper, points_[order_[k]]);
    }
    const std::size_t mine = nodes_.size();
    nodes_.push_back(made);
    if (end - begin <= leaf) return;
    const vector size = made.upper - made.lower;
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (size[k] > size[axis]) axis = k;
    const auto middle = begin + (end - begin) / 2;
    std::nth_element(
        order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
        [&](std::uint32_t a, std::uint32_t b) {
          return points_[a][axis] != points_[b][axis] ? points_[a][axis] < points_[b][axis] : a < b;
        });
    build(begin, middle);
    nodes_[mine].right = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end);
  }

  const plain_vector<vector>& points_;
  plain_vector<std::uint32_t> order_;
  plain_vector<node> nodes_;
};

}  // namespace talus::detail
