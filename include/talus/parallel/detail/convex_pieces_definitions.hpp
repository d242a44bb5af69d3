#pragma once
// The definitions of convex_pieces.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/detail/convex_pieces.hpp"

namespace talus::detail {

TALUS_INLINE scaled_planes::scaled_planes(std::span<const half_space> planes, real least_unit)
    : planes_(planes) {
  unit_ = least_unit;
  for (int k = 0; k < 3; ++k) {
    real low = 0, high = 0;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const real foot = planes[i].normal()[k] * planes[i].displacement();
      low = i == 0 ? foot : std::min(low, foot);
      high = i == 0 ? foot : std::max(high, foot);
    }
    origin_[k] = low + (high - low) / 2;
    unit_ = std::max(unit_, high - low);
  }
  // If all planes meet in a point, any unit above round-off is suitable.
  const real offset = largest(origin_);
  if (!(unit_ > 1e-12 * offset)) unit_ = std::max(real(1), offset);
}

TALUS_INLINE lp_bound scaled_planes::bound(const half_space& h, real depth, real slack) const {
  const vec3 n = h.normal();
  return {{n[0], n[1], n[2], -depth}, -h.value(origin_) / unit_ - slack};
}

TALUS_INLINE plain_vector<lp_bound> scaled_planes::bounds(real depth, real slack) const {
  plain_vector<lp_bound> result;
  for (const half_space& h : planes_) result.push_back(bound(h, depth, slack));
  return result;
}

TALUS_INLINE depth_and_point deepest_point(std::span<const half_space> planes, real least_unit) {
  const scaled_planes scaled(planes, least_unit);
  auto bounds = scaled.bounds(1);
  bounds.push_back({{0, 0, 0, -1}, -1});
  const auto x = maximize(4, bounds, {0, 0, 0, 1});
  if (!x) return {-lp_far * scaled.unit(), {0, 0, 0}};
  return {(*x)[3] * scaled.unit(), scaled.point(*x)};
}

TALUS_INLINE bool has_interior(std::span<const half_space> planes) {
  const real unit = scaled_planes(planes).unit();
  return deepest_point(planes).depth > scaled_planes::tiny * unit;
}

TALUS_INLINE convex_piece joined(const convex_piece& a, const convex_piece& b) {
  convex_piece all = a;
  for (const half_space& h : b)
    if (std::find(all.begin(), all.end(), h) == all.end()) all.push_back(h);
  return all;
}

TALUS_INLINE bool come_within(const convex_piece& a, const convex_piece& b, real reach) {
  const convex_piece all = joined(a, b);
  const real unit = scaled_planes(all, reach).unit();
  return deepest_point(all, reach).depth >= -reach / 2 - scaled_planes::tiny * unit;
}

TALUS_INLINE bool touch_only_in(const convex_piece& a, const convex_piece& b,
                                const convex_piece& face) {
  const convex_piece common = joined(a, b), all = joined(common, face);
  const scaled_planes scaled(all);
  plain_vector<lp_bound> bounds;
  for (const half_space& h : common) bounds.push_back(scaled.bound(h, 0, scaled_planes::tiny));
  return std::all_of(face.begin(), face.end(), [&](const half_space& h) {
    const auto [n, d] = scaled.bound(h);
    const auto x = maximize(3, bounds, {-n[0], -n[1], -n[2]});
    return x && n[0] * (*x)[0] + n[1] * (*x)[1] + n[2] * (*x)[2] - d > -1e-5;
  });
}

TALUS_INLINE void drop_redundant(convex_piece& piece) {
  for (std::size_t i = 0; i < piece.size() && piece.size() > 1;) {
    const scaled_planes scaled(piece);
    auto bounds = scaled.bounds();
    const lp_bound own = bounds[i];
    bounds.erase(bounds.begin() + static_cast<std::ptrdiff_t>(i));
    const auto x = maximize(3, bounds, {-own.a[0], -own.a[1], -own.a[2]});
    const bool redundant =
        x && own.a[0] * (*x)[0] + own.a[1] * (*x)[1] + own.a[2] * (*x)[2] >= own.b - 1e-12;
    if (redundant)
      piece.erase(piece.begin() + static_cast<std::ptrdiff_t>(i));
    else
      ++i;
  }
}

TALUS_INLINE bool overlap(std::span<const convex_piece> some,
                          std::span<const convex_piece> others) {
  for (const convex_piece& a : some)
    for (const convex_piece& b : others)
      if (has_interior(joined(a, b))) return true;
  return false;
}

TALUS_INLINE std::vector<convex_piece> without(std::vector<convex_piece> pieces,
                                               std::span<const convex_piece> taken) {
  for (const convex_piece& cut : taken) {
    std::vector<convex_piece> rest;
    for (convex_piece& piece : pieces) {
      if (!has_interior(joined(piece, cut))) {
        rest.push_back(std::move(piece));
        continue;
      }
      for (const half_space& h : cut) {
        convex_piece beyond = joined(piece, {h.flipped()});
        if (has_interior(beyond)) {
          drop_redundant(beyond);
          rest.push_back(std::move(beyond));
        }
        piece = joined(piece, {h});
      }
    }
    pieces = std::move(rest);
  }
  return pieces;
}

TALUS_INLINE void piece_collector::open(bool all_of) {
  levels_.push_back({all_of, {}});
  if (all_of) levels_.back().pieces.emplace_back();
}

TALUS_INLINE void piece_collector::close() {
  const auto inner = std::move(levels_.back().pieces);
  levels_.pop_back();
  fold(inner);
}

TALUS_INLINE void piece_collector::fold(const std::vector<convex_piece>& more) {
  auto& [all_of, pieces] = levels_.back();
  if (!all_of) {
    for (convex_piece& piece : without(more, pieces)) pieces.push_back(std::move(piece));
  } else {
    std::vector<convex_piece> product;
    for (const convex_piece& a : pieces)
      for (const convex_piece& b : more)
        if (convex_piece both = joined(a, b); has_interior(both))
          product.push_back(std::move(both));
    pieces = std::move(product);
  }
  if (pieces.size() > most_)
    fail<std::invalid_argument>(
        "a region falls into more than {} convex pieces; describe it by fewer half-spaces", most_);
}

TALUS_INLINE std::pair<vec3, vec3> bounds_of(std::span<const convex_piece> pieces) {
  constexpr real infinity = std::numeric_limits<real>::infinity();
  vec3 lower{infinity, infinity, infinity}, upper{-infinity, -infinity, -infinity};
  for (const convex_piece& piece : pieces) {
    const scaled_planes scaled(piece);
    const auto bounds = scaled.bounds();
    auto directions = bounds;  // unbounded directions
    for (lp_bound& bound : directions) bound.b = 0;
    for (std::size_t i = 0; i < 6; ++i) {
      const std::size_t axis = i / 2;
      const real sign = i % 2 == 0 ? 1 : -1;
      lp_vector c{};
      c[axis] = sign;
      const auto x = maximize(3, bounds, c), away = maximize(3, directions, c);
      const bool bounded = x && away && sign * (*away)[axis] < 1e-6 * lp_far;
      const auto k = static_cast<std::ptrdiff_t>(axis);
      const real at = bounded ? scaled.point(*x)[k] + sign * scaled_planes::tiny * scaled.unit()
                              : sign * infinity;
      sign > 0 ? upper[k] = std::max(upper[k], at) : lower[k] = std::min(lower[k], at);
    }
  }
  return {lower, upper};
}

TALUS_INLINE vec3 nearest_point(const convex_piece& piece, const vec3& p) {
  real size = largest(p);
  for (const half_space& h : piece) size = std::max(size, std::abs(h.displacement()));
  const real slack = 1e-12 * size;
  const auto inside = [&](const vec3& q) {
    return std::all_of(piece.begin(), piece.end(),
                       [&](const half_space& h) { return h.value(q) >= -slack; });
  };
  if (inside(p)) return p;
  vec3 best = p;
  real least = std::numeric_limits<real>::infinity();
  const auto consider = [&](const vec3& q) {
    const vec3 way = plus(q, -1, p);
    if (const real square = dot(way, way); square < least && inside(q)) least = square, best = q;
  };
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const vec3 a = piece[i].normal();
    const vec3 on_plane = plus(p, -piece[i].value(p), a);
    consider(on_plane);
    for (std::size_t j = i + 1; j < piece.size(); ++j) {
      const vec3 n = piece[j].normal();
      const vec3 across = plus(n, -dot(n, a), a);
      if (largest(across) < 1e-9) continue;
      const vec3 b = unit(across);
      const vec3 on_edge = plus(on_plane, -piece[j].value(on_plane) / dot(n, b), b);
      consider(on_edge);
      const vec3 along = cross(a, b);
      for (std::size_t k = j + 1; k < piece.size(); ++k)
        if (const real slope = dot(piece[k].normal(), along); std::abs(slope) > 1e-9)
          consider(plus(on_edge, -piece[k].value(on_edge) / slope, along));
    }
  }
  return best;
}

}  // namespace talus::detail
