#pragma once
// The triangles of surfaces near bodies, kept from step to step while a body moves little relative
// to the surface (as the pairs of a neighbour list are). They are found in the frame of the
// surface, which may itself move. A search among them gives the triangles that a search in the
// whole surface gives, in the same order.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/shape/triangle_tree.hpp"

namespace talus::detail {

/// The triangles of a surface whose boxes overlap a cube around a body.
struct near_triangles {
  vec3 centre{0, 0, 0};  ///< of the cube
  real half = -1;        ///< of its edge; negative if nothing is known yet
  std::uint32_t surface = 0;
  std::uint32_t first = 0, count = 0, room = 0;  ///< in the list of numbers

  [[nodiscard]] bool covers(const vec3& lower, const vec3& upper) const {
    const vec3 edge(half, half, half), low = centre - edge, high = centre + edge;
    return half >= 0 && low[0] <= lower[0] && low[1] <= lower[1] && low[2] <= lower[2] &&
           high[0] >= upper[0] && high[1] >= upper[1] && high[2] >= upper[2];
  }
};

class near_triangle_lists;

/// A surface beside one body: a shape of its own for pair functions.
struct surface_near_body {
  static constexpr bool finite = true;
  static constexpr bool isotropic = false;

  const triangle_tree* all;
  near_triangle_lists* lists;
  std::size_t kept;

  [[nodiscard]] const triangle_tree& tree() const { return *all; }
  /// Does what triangle_mesh::each_within() does.
  template <class F>
  void each_within(const vec3& centre, const vec3& reach, real size, F&& f) const;
};

/// The triangles near all bodies of a shape. Bodies are known by their indices; as a list is valid
/// for any body whose box lies in its cube, it needs no update if bodies migrate.
class near_triangle_lists {
  static constexpr real skin_part = 0.25;     ///< half the edge of a cube exceeds the body by this
  static constexpr real wide = 3;             ///< times that of a cube without triangles
  static constexpr std::uint32_t most = 256;  ///< triangles in a list
  static constexpr std::uint32_t too_many = ~std::uint32_t{0};
  static constexpr std::size_t most_ways = 4;  ///< lists of a body

 public:
  using view = surface_near_body;

  /// For body i and surface j of `surfaces`.
  [[nodiscard]] surface_near_body of(std::size_t i, std::size_t j, std::size_t surfaces,
                                     const std::shared_ptr<const triangle_tree>& tree) {
    if (j >= known_.size() || known_[j] != tree) note(j, tree);
    const std::size_t ways = std::min(surfaces, most_ways);
    if (ways != ways_) ways_ = ways, forget();
    const std::size_t at = i * ways + j % ways;
    if (at >= bodies_.size()) bodies_.resize(std::max(at + 1, bodies_.size() * 3 / 2));
    near_triangles& kept = bodies_[at];
    if (kept.surface != j) kept.surface = static_cast<std::uint32_t>(j), kept.half = -1;
    return {tree.get(), this, at};
  }
  template <class F>
  void each_within(const triangle_tree& tree, std::size_t body, const vec3& centre,
                   const vec3& reach, real size, F&& f) {
    near_triangles& kept = bodies_[body];
    const vec3 lower = centre - reach, upper = centre + reach;
    if (!kept.covers(lower, upper)) find(kept, tree, centre, std::max(size, reach.maxCoeff()));
    if (kept.count == too_many) return tree.each_within(lower, upper, f);
    const std::uint32_t* const numbers = numbers_.data() + kept.first;
    for (std::uint32_t k = 0; k < kept.count; ++k)
      if (tree.overlaps(numbers[k], lower, upper)) f(numbers[k]);
  }
  [[nodiscard]] std::size_t bytes() const {
    return bodies_.capacity() * sizeof(near_triangles) +
           (numbers_.capacity() + found_.capacity()) * sizeof(std::uint32_t);
  }

 private:
  void find(near_triangles& kept, const triangle_tree& tree, const vec3& centre, real size) {
    if (unused_ > numbers_.size() / 2 + 4096) forget();
    search(kept, tree, centre, (1 + skin_part) * size);
    if (found_.empty()) {
      search(kept, tree, centre, wide * size);
      if (!found_.empty()) kept.half = (1 + skin_part) * size, found_.clear();
    }
    const auto count = static_cast<std::uint32_t>(found_.size());
    kept.count = count > most ? too_many : count;
    if (kept.count == too_many || count == 0) return;
    if (count > kept.room) {
      unused_ += kept.room;
      kept.first = static_cast<std::uint32_t>(numbers_.size()), kept.room = count;
      numbers_.resize(numbers_.size() + count);
    }
    std::copy(found_.begin(), found_.end(), numbers_.begin() + kept.first);
  }
  void search(near_triangles& kept, const triangle_tree& tree, const vec3& centre, real half) {
    kept.centre = centre, kept.half = half;
    const vec3 edge(half, half, half);
    found_.clear();
    tree.each_within(centre - edge, centre + edge, [&](std::uint32_t t) { found_.push_back(t); });
  }
  void forget() {
    numbers_.clear(), unused_ = 0;
    bodies_.assign(bodies_.size(), {});
  }
  [[gnu::cold, gnu::noinline]] void note(std::size_t j,
                                         const std::shared_ptr<const triangle_tree>& tree) {
    if (j >= known_.size()) known_.resize(j + 1);
    known_[j] = tree;
    forget();
  }

  std::vector<std::shared_ptr<const triangle_tree>> known_;  ///< by the number of the surface
  std::size_t ways_ = 0;
  plain_vector<near_triangles> bodies_;
  plain_vector<std::uint32_t> numbers_, found_;
  std::size_t unused_ = 0;  ///< numbers in no list
};

template <class F>
void surface_near_body::each_within(const vec3& centre, const vec3& reach, real size, F&& f) const {
  lists->each_within(*all, kept, centre, reach, size, f);
}

}  // namespace talus::detail
