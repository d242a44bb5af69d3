#pragma once
// A tree of boxes, made for one set of queries: which of them a line meets, and which are near a
// point. Building takes a time of n log n, a query one of log n for each box that it finds.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/detect/surface_hit.hpp"

namespace talus::detail {

class bounds_tree {
 public:
  struct bounds {
    vec3 lower{endless, endless, endless}, upper{-endless, -endless, -endless};

    void include(const bounds& other) {
      lower = lower.cwiseMin(other.lower), upper = upper.cwiseMax(other.upper);
    }
    [[nodiscard]] bool empty() const { return !(lower[0] <= upper[0]); }
  };

  /// Adds the box `centre` ± `half`, widened by round-off. Its number is that of boxes so far.
  void add(const vec3& centre, const vec3& half) {
    const real more = real(1e-9) * half.maxCoeff() + real(1e-12) * max_norm(centre);
    const vec3 reach = half + vec3(more, more, more);
    boxes_.push_back({centre - reach, centre + reach});
    around_.include(boxes_.back());
  }
  [[nodiscard]] std::size_t size() const { return boxes_.size(); }
  /// The box around all.
  [[nodiscard]] const bounds& around() const { return around_; }

  /// Calls f(number) for the boxes, widened by `reach`, that the line p + t d meets at a t from 0
  /// to `length`, nearer ones mostly first; f returns the length from then on.
  template <class F>
  void along(const vec3& p, const vec3& d, real length, const vec3& reach, F&& f) {
    const auto entry = [&](const bounds& b) {
      const chord c = chord_of_bounds(b.lower - reach, b.upper + reach, p, d);
      return c.from <= c.to && c.to >= 0 ? std::max(c.from, real(0)) : endless;
    };
    search(entry, length, f);
  }
  /// Calls f(number) for the boxes within `distance` of p, nearer ones mostly first; f returns the
  /// distance from then on.
  template <class F>
  void near(const vec3& p, real distance, F&& f) {
    const auto away = [&](const bounds& b) {
      return std::sqrt(square_to_bounds(b.lower, b.upper, p));
    };
    search(away, distance, f);
  }

 private:
  /// A node of the tree, as in triangle_tree: it holds the boxes order_[first, first + count), or,
  /// where count is 0, the next node and `first`.
  struct node {
    bounds box;
    std::uint32_t first = 0, count = 0;
  };

  template <class Away, class F>
  void search(const Away& away, real limit, F&& f) {
    if (boxes_.empty()) return;
    if (nodes_.empty()) build();
    waiting_.clear();
    const auto visit = [&](std::uint32_t at) {
      const real distance = away(nodes_[at].box);
      if (distance < endless && distance <= limit) waiting_.push_back({at, distance});
    };
    visit(0);
    while (!waiting_.empty()) {
      const auto [at, distance] = waiting_.back();
      waiting_.pop_back();
      if (!(distance <= limit)) continue;
      const node& n = nodes_[at];
      if (n.count == 0) {
        const std::size_t before = waiting_.size();
        visit(n.first), visit(at + 1);
        if (waiting_.size() == before + 2 &&
            waiting_[before].distance < waiting_[before + 1].distance)
          std::swap(waiting_[before], waiting_[before + 1]);
        continue;
      }
      for (std::uint32_t k = n.first; k < n.first + n.count; ++k) {
        const real to_box = away(boxes_[order_[k]]);
        if (to_box < endless && to_box <= limit) limit = f(order_[k]);
      }
    }
  }
  void build() {
    order_.resize(boxes_.size());
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.reserve(boxes_.size());
    divide(0, static_cast<std::uint32_t>(order_.size()));
  }
  /// Appends the node of order_[from, to) and all below it: halves along the longest side of the
  /// box around the centres.
  void divide(std::uint32_t from, std::uint32_t to) {
    constexpr std::uint32_t few = 4;
    const std::size_t at = nodes_.size();
    nodes_.push_back({});
    bounds all, centres;
    const auto twice_centre = [&](std::uint32_t k) {
      return vec3(boxes_[k].lower + boxes_[k].upper);
    };
    for (std::uint32_t k = from; k < to; ++k) {
      all.include(boxes_[order_[k]]);
      const vec3 c = twice_centre(order_[k]);
      centres.include({c, c});
    }
    nodes_[at].box = all;
    if (to - from <= few) {
      nodes_[at].first = from, nodes_[at].count = to - from;
      return;
    }
    const vec3 size = centres.upper - centres.lower;
    int axis = size[1] > size[0] ? 1 : 0;
    if (size[2] > size[axis]) axis = 2;
    const auto middle = from + (to - from) / 2;
    std::nth_element(order_.begin() + from, order_.begin() + middle, order_.begin() + to,
                     [&](std::uint32_t a, std::uint32_t b) {
                       const real x = twice_centre(a)[axis], y = twice_centre(b)[axis];
                       return x != y ? x < y : a < b;
                     });
    divide(from, middle);
    nodes_[at].first = static_cast<std::uint32_t>(nodes_.size());
    divide(middle, to);
  }

  struct waiting {
    std::uint32_t node;
    real distance;
  };
  std::vector<bounds> boxes_;
  bounds around_;
  std::vector<std::uint32_t> order_;
  std::vector<node> nodes_;
  std::vector<waiting> waiting_;
};

}  // namespace talus::detail
