#pragma once
// The order of elimination of the unknowns of bodies, for little fill-in.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Which unknowns touch each other: symmetric, without loops, each pair once in each row.
struct sparse_graph {
  plain_vector<std::int32_t> start{0};  ///< of each row in `column`, and the end
  plain_vector<std::int32_t> column;

  [[nodiscard]] std::int32_t rows() const { return static_cast<std::int32_t>(start.size()) - 1; }
  [[nodiscard]] std::span<const std::int32_t> row(std::int32_t i) const {
    const auto first = static_cast<std::size_t>(start[static_cast<std::size_t>(i)]);
    return {column.data() + first,
            static_cast<std::size_t>(start[static_cast<std::size_t>(i) + 1]) - first};
  }
};

/// Approximate minimum degree (Amestoy, Davis, Duff 1996) without mass elimination. Unknowns with
/// very many neighbours, such as a plate on thousands of spheres, come last. The result includes
/// the unknowns that each elimination touches, so that no further symbolic phase is needed.
class elimination_order {
 public:
  /// Stops if the factors would have more than `most` products of blocks.
  elimination_order(const sparse_graph& g, double most)
      : n_(g.rows()),
        most_(most),
        variables_(static_cast<std::size_t>(n_)),
        elements_(static_cast<std::size_t>(n_)),
        structure_(static_cast<std::size_t>(n_)),
        size_(static_cast<std::size_t>(n_), 0),
        mark_(static_cast<std::size_t>(n_), -1),
        weight_(static_cast<std::size_t>(n_), 0),
        state_(static_cast<std::size_t>(n_), waiting),
        next_(static_cast<std::size_t>(n_), -1),
        previous_(static_cast<std::size_t>(n_), -1),
        degree_(static_cast<std::size_t>(n_), 0),
        first_(static_cast<std::size_t>(n_) + 1, -1) {
    const auto many = static_cast<std::size_t>(std::max(16., 10 * std::sqrt(n_)));
    plain_vector<std::int32_t> crowded;
    for (std::int32_t i = 0; i < n_; ++i) {
      const auto row = g.row(i);
      variables_[at(i)].append(row);
      if (row.size() > many)
        crowded.push_back(i), state_[at(i)] = last;
      else
        put(i, static_cast<std::int32_t>(row.size()));
    }
    for (std::int32_t i = take(); i >= 0 && possible(); i = take()) eliminate(i);
    // They touch each other, initially or by fill-in.
    for (std::size_t k = 0; k < crowded.size(); ++k)
      finish(crowded[k], {crowded.data() + k + 1, crowded.size() - k - 1});
  }

  /// Whether the factors stay within the limit.
  [[nodiscard]] bool possible() const { return cost_ <= most_; }
  /// Products of blocks of the factorization.
  [[nodiscard]] double cost() const { return cost_; }
  [[nodiscard]] std::span<const std::int32_t> order() const {
    return {order_.data(), order_.size()};
  }
  /// The remaining unknowns that the unknown touches when it is eliminated.
  [[nodiscard]] std::span<const std::int32_t> touched(std::int32_t i) const {
    return {structure_[at(i)].data(), structure_[at(i)].size()};
  }

 private:
  enum state : char { waiting, last, gone, absorbed };

  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

  // Unknowns by degree, in lists.
  void put(std::int32_t i, std::int32_t degree) {
    degree_[at(i)] = degree;
    next_[at(i)] = first_[at(degree)];
    previous_[at(i)] = -1;
    if (next_[at(i)] >= 0) previous_[at(next_[at(i)])] = i;
    first_[at(degree)] = i;
    least_ = std::min(least_, degree);
  }
  void remove(std::int32_t i) {
    const std::int32_t before = previous_[at(i)], after = next_[at(i)];
    (before >= 0 ? next_[at(before)] : first_[at(degree_[at(i)])]) = after;
    if (after >= 0) previous_[at(after)] = before;
  }
  std::int32_t take() {
    while (least_ <= n_ && first_[at(least_)] < 0) ++least_;
    if (least_ > n_) return -1;
    const std::int32_t i = first_[at(least_)];
    remove(i);
    return i;
  }

  void finish(std::int32_t i, std::span<const std::int32_t> touched) {
    order_.push_back(i);
    if (touched.data() != structure_[at(i)].data()) structure_[at(i)].append(touched);
    const auto h = static_cast<double>(touched.size());
    cost_ += (h + 1) * (h + 1);
  }

  void eliminate(std::int32_t p) {
    auto& touched = structure_[at(p)];
    ++stamp_;
    mark_[at(p)] = stamp_;
    crowd_.clear();
    const auto add = [&](std::span<const std::int32_t> list) {
      for (const std::int32_t i : list)
        if (state_[at(i)] <= last && mark_[at(i)] != stamp_) {
          mark_[at(i)] = stamp_;
          (state_[at(i)] == last ? crowd_ : touched).push_back(i);
        }
    };
    add({variables_[at(p)].data(), variables_[at(p)].size()});
    for (const std::int32_t e : elements_[at(p)]) {
      add({structure_[at(e)].data(), structure_[at(e)].size()});
      state_[at(e)] = absorbed;
    }
    state_[at(p)] = gone;
    const auto own = size_[at(p)] = static_cast<std::int32_t>(touched.size());
    touched.append(crowd_.data(), crowd_.size());
    finish(p, {touched.data(), touched.size()});

    // How much of each other element lies outside of the unknowns touched here.
    base_ += n_ + 1;
    for (const std::int32_t i : touched) {
      if (state_[at(i)] == last) continue;
      auto& list = elements_[at(i)];
      std::size_t kept = 0;
      for (const std::int32_t e : list) {
        if (state_[at(e)] == absorbed) continue;
        list[kept++] = e;
        auto& w = weight_[at(e)];
        if (w < base_) w = base_ + size_[at(e)];
        --w;
      }
      list.resize(kept);
    }
    const auto left = n_ - static_cast<std::int32_t>(order_.size());
    for (const std::int32_t i : touched) {
      if (state_[at(i)] == last) continue;
      auto& list = variables_[at(i)];
      std::size_t kept = 0;
      for (const std::int32_t j : list)
        if (state_[at(j)] <= last && mark_[at(j)] != stamp_) list[kept++] = j;
      list.resize(kept);
      std::int64_t degree = static_cast<std::int64_t>(kept) + own - 1;
      auto& of = elements_[at(i)];
      kept = 0;
      for (const std::int32_t e : of) {
        const std::int64_t outside = weight_[at(e)] - base_;
        if (outside == 0 && crowd_is_marked(e)) continue;  // within the unknowns touched here
        of[kept++] = e;
        degree += outside;
      }
      of.resize(kept);
      of.push_back(p);
      remove(i);
      put(i, static_cast<std::int32_t>(std::min<std::int64_t>(degree, left)));
    }
  }

  /// Whether the crowded unknowns of an element are touched by the present one.
  [[nodiscard]] bool crowd_is_marked(std::int32_t e) const {
    const auto& list = structure_[at(e)];
    for (std::size_t k = at(size_[at(e)]); k < list.size(); ++k)
      if (mark_[at(list[k])] != stamp_) return false;
    return true;
  }

  std::int32_t n_;
  double most_, cost_ = 0;
  vector_of<plain_vector<std::int32_t>> variables_, elements_, structure_;
  plain_vector<std::int32_t> size_;  ///< of the elements, without crowded unknowns
  plain_vector<std::int32_t> mark_;
  plain_vector<std::int64_t> weight_;
  plain_vector<state> state_;
  plain_vector<std::int32_t> next_, previous_, degree_, first_;
  plain_vector<std::int32_t> order_, crowd_;
  std::int32_t least_ = 0, stamp_ = 0;
  std::int64_t base_ = 0;
};

}  // namespace talus::detail
