#pragma once
// The parts of a union in the frame of its body, and the values computed from them. All bodies of
// that form share them.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/math.hpp"
#include "talus/core/shared_data.hpp"
#include "talus/core/type_list.hpp"
#include "talus/shape/frame.hpp"

namespace talus::detail {

/// Distance of the furthest point of a posed shape from the origin, or a bound of it for shapes
/// without `reach_from`.
template <class Shape>
[[nodiscard]] real furthest_from_origin(const Shape& s, const pose& at) {
  if constexpr (requires { s.reach_from(at.position); })
    return s.reach_from(at.to_body(vec3(0, 0, 0)));
  else
    return at.position.norm() + s.bounding_radius();
}

/// One part: where it is and how far it reaches.
template <class Shape>
struct union_part {
  Shape shape;
  pose at;           ///< in the frame of the body of the union
  real density = 1;  ///< relative
};

template <class... Shapes>
struct union_parts {
  /// Where to find part number n, and the ball around it.
  struct entry {
    vec3 centre;
    real reach;
    std::uint32_t kind, index;
  };

  std::tuple<std::vector<union_part<Shapes>>...> of_kind;
  std::vector<entry> entries;
  std::vector<std::uint32_t> sorted;  ///< numbers of the parts along `axis`
  int axis = 0;
  real furthest = 0;  ///< largest reach of a part
  real volume = 0, bounding_radius = 0, least_extent = 0;
  vec3 inertia{0, 0, 0};
  pose frame;  ///< of the body, in the coordinates of the user
  content_id id;

  /// Calls f(shape, pose, density) for part number n.
  template <class F>
  void visit(std::size_t n, F&& f) const {
    visit_kind(n, f, std::index_sequence_for<Shapes...>{});
  }
  /// Calls f(n) for the parts whose balls come within `reach` of a point of the body's frame: of
  /// the parts sorted along the axis with the largest spread, only those beside it are tested.
  template <class F>
  void near(const vec3& point, real reach, F&& f) const {
    const real low = point[axis] - reach - furthest, high = point[axis] + reach + furthest;
    auto it = std::lower_bound(sorted.begin(), sorted.end(), low, [&](std::uint32_t n, real x) {
      return entries[n].centre[axis] < x;
    });
    for (; it != sorted.end(); ++it) {
      const entry& e = entries[*it];
      if (e.centre[axis] > high) return;
      const real x = e.centre[0] - point[0], y = e.centre[1] - point[1], z = e.centre[2] - point[2],
                 sum = e.reach + reach;
      if (x * x + y * y + z * z <= sum * sum) f(*it);
    }
  }
  /// After the last part.
  void sort() {
    vec3 low = entries[0].centre, high = low;
    for (const entry& e : entries)
      for (int i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], e.centre[i]), high[i] = std::max(high[i], e.centre[i]);
        furthest = std::max(furthest, e.reach);
      }
    for (int i = 1; i < 3; ++i)
      if (high[i] - low[i] > high[axis] - low[axis]) axis = i;
    for (std::uint32_t n = 0; n < entries.size(); ++n) sorted.push_back(n);
    std::stable_sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
      return entries[a].centre[axis] < entries[b].centre[axis];
    });
    find_least_extent();
  }
  /// Appends a part whose pose is already that in the frame of the body.
  template <class Shape>
  void add(const Shape& shape, const pose& at, real density) {
    auto& list = std::get<std::vector<union_part<Shape>>>(of_kind);
    constexpr std::uint32_t kind = index_of<type_list<Shapes...>, Shape>;
    entries.push_back(
        {at.position, shape.bounding_radius(), kind, static_cast<std::uint32_t>(list.size())});
    bounding_radius = std::max(bounding_radius, furthest_from_origin(shape, at));
    list.push_back({shape, at, density});
  }

  void pack(byte_writer& out) const {
    out.put(entries.size());
    for (std::size_t n = 0; n < entries.size(); ++n) {
      out.put(entries[n].kind);
      visit(n, [&](const auto& shape, const pose& at, real density) {
        out.put(shape), out.put(at.position), out.put(at.orientation), out.put(density);
      });
    }
    out.put(volume), out.put(inertia), out.put(frame.position), out.put(frame.orientation);
    out.put(id);
  }
  static union_parts unpack(byte_reader& in) {
    union_parts u;
    const auto parts = in.get<std::size_t>();
    for (std::size_t n = 0; n < parts; ++n) {
      const auto kind = in.get<std::uint32_t>();
      if (kind >= sizeof...(Shapes)) refuse();
      u.unpack_part(kind, in, std::index_sequence_for<Shapes...>{});
    }
    if (parts == 0) refuse();
    u.sort();
    u.volume = in.get<real>();
    u.inertia = in.get<vec3>();
    u.frame.position = in.get<vec3>();
    u.frame.orientation = in.get<quat>();
    u.id = in.get<content_id>();
    if (!(u.volume > 0 && std::isfinite(u.volume) && std::isfinite(u.bounding_radius) &&
          u.inertia.allFinite() && u.inertia.minCoeff() > 0 && sound(u.frame)))
      refuse();
    return u;
  }

 private:
  void find_least_extent() {
    least_extent = std::numeric_limits<real>::infinity();
    for (int k = 0; k < 3; ++k)
      for (const real sign : {-1., 1.}) {
        const vec3 d = sign * vec3::Unit(k);
        real most = -std::numeric_limits<real>::infinity();
        for (std::size_t n = 0; n < entries.size(); ++n)
          visit(n, [&](const auto& shape, const pose& at, real) {
            const vec3 p =
                at.to_world(shape.support(inverse({{0, 0, 0}, at.orientation}).to_world(d)));
            most = std::max(most, sign * p[k]);
          });
        least_extent = std::min(least_extent, most);
      }
    if (!(least_extent > 0)) least_extent = real(0.05) * bounding_radius;
  }
  /// Throws runtime_error for invalid bytes, which a damaged file may contain.
  [[noreturn, gnu::cold]] static void refuse() {
    throw std::runtime_error("is damaged: a union_of makes no sense");
  }
  [[nodiscard]] static bool sound(const pose& at) {
    return at.position.allFinite() && std::abs(at.orientation.squaredNorm() - 1) < 1e-6;
  }
  template <class F, std::size_t... Kinds>
  void visit_kind(std::size_t n, F&& f, std::index_sequence<Kinds...>) const {
    const entry& e = entries[n];
    const auto call = [&](const auto& part) { f(part.shape, part.at, part.density); };
    ((e.kind == Kinds ? call(std::get<Kinds>(of_kind)[e.index]) : void()), ...);
  }
  template <std::size_t... Kinds>
  void unpack_part(std::uint32_t kind, byte_reader& in, std::index_sequence<Kinds...>) {
    const auto read = [&]<class Shape>(const std::vector<union_part<Shape>>&) {
      auto shape = in.get<Shape>();
      const auto position = in.get<vec3>();
      const auto orientation = in.get<quat>();
      const auto density = in.get<real>();
      shape.validate();
      if (!sound({position, orientation}) || !(density >= 0) || !std::isfinite(density)) refuse();
      add(shape, pose{position, orientation}, density);
    };
    ((kind == Kinds ? read(std::get<Kinds>(of_kind)) : void()), ...);
  }
};

}  // namespace talus::detail
