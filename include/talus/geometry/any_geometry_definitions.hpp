#pragma once
// The definitions of any_geometry.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/geometry/any_geometry.hpp"

namespace talus {

TALUS_INLINE any_geometry any_geometry::cell(std::span<const half_space> planes) {
  detail::geometry_builder builder;
  for (const half_space& h : planes) builder.plane(h);
  any_geometry g;
  g.adopt(builder);
  return g;
}

TALUS_INLINE real any_geometry::value(const vec3& p) const {
  if (!program_.empty()) return run(p);
  real result = neutral(all_of_);
  if (all_of_)
    for (const half_space& h : planes_) result = std::min(h.value(p), result);
  else
    for (const half_space& h : planes_) result = std::max(h.value(p), result);
  return result;
}

TALUS_INLINE bool any_geometry::owns(const vec3& p) const {
  const auto inside = [&](const half_space& h) { return h.owns(p); };
  if (!program_.empty()) return run_owns(p);
  const auto first = planes_.begin(), last = planes_.end();
  return all_of_ ? std::all_of(first, last, inside) : std::any_of(first, last, inside);
}

TALUS_INLINE void any_geometry::write(detail::byte_writer& out) const {
  out.put(all_of_);
  out.put(std::span<const half_space>(planes_));
  out.put(std::span<const token>(program_));
  out.put(depth_);
}

TALUS_INLINE any_geometry any_geometry::read(detail::byte_reader& in) {
  any_geometry g;
  g.all_of_ = in.get<bool>();
  g.planes_.clear();
  for (auto n = in.get<std::size_t>(); n > 0; --n) g.planes_.push_back(read_plane(in));
  g.program_ = in.get_all<token>();
  g.depth_ = in.get<int>();
  return g;
}

TALUS_INLINE half_space any_geometry::read_plane(detail::byte_reader& in) {
  half_space h(1, 0, 0, 0);
  const auto raw = in.get<std::array<std::byte, sizeof(half_space)>>();
  std::memcpy(static_cast<void*>(&h), raw.data(), sizeof h);
  return h;
}

}  // namespace talus
