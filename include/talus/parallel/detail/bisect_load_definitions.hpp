#pragma once
// The definitions of bisect_load.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/detail/bisect_load.hpp"

namespace talus::detail {

TALUS_INLINE std::array<part_to_cut, 2> part_to_cut::halves() const {
  return {
      part_to_cut{number + 1, below(), space.below(cut)},
      part_to_cut{number + static_cast<std::size_t>(below()), ranks - below(), space.above(cut)}};
}

TALUS_INLINE std::array<real, 2> part_to_cut::range(const cut_bounds& box, std::size_t axis) const {
  const real width = box.upper[axis] - box.lower[axis], least = narrowest * ranks * width;
  real from = space.lower[axis], to = space.upper[axis];
  if (!std::isfinite(from)) from = box.lower[axis] < to - least ? box.lower[axis] : to - width;
  if (!std::isfinite(to)) to = box.upper[axis] > from + least ? box.upper[axis] : from + width;
  return {from, to};
}

TALUS_INLINE void part_to_cut::cut_volume(const cut_bounds& box, int axis) {
  const auto [from, to] = range(box, static_cast<std::size_t>(axis));
  cut = {axis, from + (to - from) * below() / ranks};
}

TALUS_INLINE void part_to_cut::cut_between(real last, real next, const cut_bounds& box) {
  if (!std::isfinite(last) || !std::isfinite(next)) return cut_volume(box, cut.axis);
  const auto k = static_cast<std::size_t>(cut.axis);
  const real least = narrowest * (box.upper[k] - box.lower[k]), middle = last + (next - last) / 2;
  const real least_above = space.upper[k] - (ranks - below()) * least;
  cut.at = std::max(std::min(last < middle ? middle : next, least_above),
                    space.lower[k] + below() * least);
}

TALUS_INLINE int longest_axis(const std::array<real, 3>& extents, const cut_bounds& box) {
  int longest = -1;
  for (int k = 0; k < 3; ++k)
    if (const auto i = static_cast<std::size_t>(k);
        box.open[i] && (longest < 0 || extents[i] > extents[static_cast<std::size_t>(longest)]))
      longest = k;
  return longest;
}

TALUS_INLINE int longest_axis(const part_to_cut& part, const cut_bounds& box) {
  std::array<real, 3> extents{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [from, to] = part.range(box, k);
    extents[k] = to - from;
  }
  return longest_axis(extents, box);
}

TALUS_INLINE std::vector<part_to_cut> equal_parts(const cut_bounds& box, int ranks) {
  std::vector<part_to_cut> open{{.ranks = ranks}}, all;
  while (!open.empty()) {
    part_to_cut part = open.back();
    open.pop_back();
    if (part.ranks == 1) continue;
    part.cut_volume(box, longest_axis(part, box));
    all.push_back(part);
    const auto [below, above] = part.halves();
    open.push_back(above);
    open.push_back(below);
  }
  return all;
}

TALUS_INLINE real cut_search::edge(std::size_t k) const {
  return k == 0      ? from
         : k == bins ? to
                     : from + (to - from) * static_cast<real>(k) / static_cast<real>(bins);
}

TALUS_INLINE std::size_t cut_search::bin(real x) const {
  if (!(x >= from) || !(x < to)) return bins;
  const real guess = (x - from) / (to - from) * static_cast<real>(bins);
  auto k = guess > 0 ? std::min(static_cast<std::size_t>(guess), bins - 1) : 0;
  while (k > 0 && x < edge(k)) --k;
  while (k + 1 < bins && x >= edge(k + 1)) ++k;
  return k;
}

TALUS_INLINE void cut_search::narrow(std::span<const std::uint64_t> weights, bool last) {
  std::size_t k = 0;
  while (k + 1 < bins && below + weights[k] < target) below += weights[k++];
  const real low = edge(k), high = edge(k + 1), middle = low + (high - low) / 2;
  const std::uint64_t short_of = target - std::min(target, below);
  const std::uint64_t beyond = below + weights[k] - target;
  found = last || std::min(short_of, beyond) <= enough || !(low < middle && middle < high);
  from = found && beyond <= short_of ? high : low;
  to = high;
}

}  // namespace talus::detail
