#pragma once
// The bodies of a rank as queries see them: in trees of their boxes, and as images of a periodic
// box. Made anew for each call, from the present positions: the grids of the search for pairs are
// those of the start of the last step.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "talus/body/store.hpp"
#include "talus/core/id.hpp"
#include "talus/detect/bounds_tree.hpp"
#include "talus/detect/ray_cast.hpp"
#include "talus/features/contact_filters.hpp"
#include "talus/state/state.hpp"

namespace talus {

/// What a query finds: a body, and the place where it meets it. The same on any number of ranks, to
/// the bit, for the same bodies.
struct query_hit {
  /// The distance from the start to the place (length): infinite if nothing was found; minus the
  /// depth of an overlap
  real distance = detail::endless;
  vec3 point{0, 0, 0};   ///< on the surface of the body, in the coordinates of the query
  vec3 normal{0, 0, 0};  ///< out of the body, unit length
  system_id id = no_id;  ///< of the body; no_id if nothing was found
  int kind = -1;         ///< number of its shape in the bodies<...> of the scenario
  bool inside = false;  ///< the start is in the body: distance 0, the normal is minus the direction
  bool global = false;  ///< the body is global

  /// Whether a body was found.
  explicit operator bool() const { return id != no_id; }
  /// The nearer one first, of equals that of the lesser id.
  friend bool operator<(const query_hit& x, const query_hit& y) {
    return x.distance != y.distance ? x.distance < y.distance : x.id < y.id;
  }
  friend bool operator==(const query_hit& x, const query_hit& y) {
    return x.distance == y.distance && x.point == y.point && x.normal == y.normal && x.id == y.id &&
           x.kind == y.kind && x.inside == y.inside && x.global == y.global;
  }
};

/// The bodies that a query regards.
struct query_filter {
  /// those with one of these groups, one for each bit; all bodies, also without
  /// features<contact_filters>
  std::uint32_t groups = ~std::uint32_t{0};
  bool fixed = true;    ///< fixed and global bodies
  bool movable = true;  ///< all others

  friend bool operator==(const query_filter&, const query_filter&) = default;
};

namespace detail {

/// What is asked, whatever the query: a point, a pose, or a way from there.
struct question {
  vec3 from{0, 0, 0};
  quat turn{1, 0, 0, 0};
  vec3 direction{0, 0, 0};  ///< unit length, or zero
  real length = 0;
  system_id except = no_id;
  std::uint32_t number = 0;
};

/// Calls f(shift, from, to) for each image of a box that the way p + t d, 0 <= t <= length, meets,
/// in the order along the way: `shift` moves the box to the image, which the way is in between
/// `from` and `to`. A way that is endless has no part along a period.
template <class F>
void each_image_along(const vec3& period, const vec3& p, const vec3& d, real length,
                      const vec3& lower, const vec3& upper, F&& f) {
  const auto along_axis = [&](const auto& self, int k, vec3 shift, real from, real to) -> void {
    if (k == 3) return f(shift, from, to);
    if (!(period[k] > 0)) return self(self, k + 1, shift, from, to);
    const real a = p[k] + (d[k] == 0 ? 0 : d[k] * from), b = p[k] + (d[k] == 0 ? 0 : d[k] * to);
    const auto first =
        static_cast<std::int64_t>(std::ceil((std::min(a, b) - upper[k]) / period[k]));
    const auto last =
        static_cast<std::int64_t>(std::floor((std::max(a, b) - lower[k]) / period[k]));
    for (std::int64_t i = 0; i <= last - first; ++i) {
      shift[k] = period[k] * static_cast<real>(d[k] < 0 ? last - i : first + i);
      if (d[k] == 0) {
        self(self, k + 1, shift, from, to);
        continue;
      }
      const real x = (lower[k] + shift[k] - p[k]) / d[k], y = (upper[k] + shift[k] - p[k]) / d[k];
      const real begins = std::max(from, std::min(x, y)), ends = std::min(to, std::max(x, y));
      if (begins <= ends) self(self, k + 1, shift, begins, ends);
    }
  };
  along_axis(along_axis, 0, vec3(0, 0, 0), 0, length);
}

/// The own bodies of a rank, and the global ones.
template <class Scenario>
class asked_bodies {
  using state_type = world_state<Scenario>;
  static constexpr bool periodic = state_type::periodic;
  struct item {
    std::uint32_t kind = 0, index = 0;
  };

 public:
  explicit asked_bodies(const state_type& s) : s_(s) {
    std::uint32_t kind = 0;
    s.each_shape([&](const auto& b) {
      using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
      if constexpr (shape::finite) add(b.movable, b.movable.locals, kind, own_, own_items_);
      if constexpr (shape::finite)
        add(b.global, b.global.size(), kind, global_, global_items_);
      else
        for (std::uint32_t i = 0; i < b.global.size(); ++i) endless_.push_back({kind, i});
      ++kind;
    });
  }

  /// The box around the bodies that this rank owns.
  [[nodiscard]] const bounds_tree::bounds& around() const { return own_.around(); }
  [[nodiscard]] std::size_t owned() const { return own_items_.size(); }
  /// Periods of space; 0 along the axes without.
  [[nodiscard]] vec3 period() const {
    if constexpr (periodic) return s_.own.box().period();
    return {0, 0, 0};
  }
  [[nodiscard]] vec3 wrapped(const vec3& p) const {
    if constexpr (periodic) return s_.own.box().wrapped(p);
    return p;
  }
  /// Calls f(shift) for the images of the box beside it, itself first.
  template <class F>
  void each_image_beside(F&& f) const {
    const vec3 all = period();
    constexpr int order[] = {0, 1, -1};
    const auto many = [&](int k) { return all[k] > 0 ? 3 : 1; };
    for (int x = 0; x < many(0); ++x)
      for (int y = 0; y < many(1); ++y)
        for (int z = 0; z < many(2); ++z)
          f(vec3(order[x] * all[0], order[y] * all[1], order[z] * all[2]));
  }

  /// Calls meet(shape, pose, from, length) for the own bodies that a way with `reach` around it may
  /// meet, and take(hit) for what that returns; `take` returns the length from then on.
  template <class Meet, class Take>
  void own_along(const question& q, const query_filter& filter, const vec3& reach, const Meet& meet,
                 const Take& take) {
    real length = q.length;
    if (own_.size() == 0) return;
    each_image_along(period(), q.from, q.direction, length, around().lower - reach,
                     around().upper + reach, [&](const vec3& shift, real from, real) {
                       if (from > length) return;
                       const vec3 start = q.from - shift;
                       own_.along(start, q.direction, length, reach, [&](std::uint32_t n) {
                         visit(own_items_[n], false, q, filter,
                               [&](const auto& shape, const pose& at, query_hit of) {
                                 length =
                                     put(of, meet(shape, at, start, length), shift, take, length);
                               });
                         return length;
                       });
                     });
  }
  /// Passes on what a shape that moves along a way meets of the global bodies. They are not
  /// repeated: a way that leaves the periodic box goes on at its other side.
  template <class Meet, class Take>
  void global_along(const question& q, const query_filter& filter, const vec3& reach,
                    const Meet& meet, const Take& take) {
    real length = q.length;
    vec3 lower(0, 0, 0), upper(0, 0, 0);
    if constexpr (periodic) lower = s_.own.box().lower(), upper = s_.own.box().upper();
    each_image_along(
        period(), q.from, q.direction, length, lower, upper,
        [&](const vec3& shift, real from, real to) {
          if (from > length) return;
          const vec3 start = q.from - shift + (from > 0 ? vec3(from * q.direction) : vec3(0, 0, 0));
          const auto rest = [&] { return std::min(to, length) - from; };
          const auto one = [&](const item& which) {
            visit(which, true, q, filter, [&](const auto& shape, const pose& at, query_hit of) {
              surface_hit hit = meet(shape, at, start, rest());
              if (hit.inside && from > 0) return;  // seen before, or beyond the side
              hit.distance += from;
              length = put(of, hit, shift, take, length);
            });
          };
          for (const item& which : endless_) one(which);
          global_.along(start, q.direction, rest(), reach, [&](std::uint32_t n) {
            one(global_items_[n]);
            return rest();
          });
        });
  }
  /// The bodies near a point: calls meet(shape, pose, from, distance) and take(hit), as above.
  template <class Meet, class Take>
  void near(const question& q, const query_filter& filter, bool global, const Meet& meet,
            const Take& take) {
    real within = q.length;
    const vec3 home = wrapped(q.from);
    const auto look = [&](const item& which, const vec3& shift) {
      visit(which, global, q, filter, [&](const auto& shape, const pose& at, query_hit of) {
        const vec3 start = home - shift;
        within = put(of, meet(shape, at, start, within), vec3(q.from - start), take, within);
      });
      return within;
    };
    const vec3 none(0, 0, 0);
    if (global) {
      for (const item& which : endless_) look(which, none);
      global_.near(home, within, [&](std::uint32_t n) { return look(global_items_[n], none); });
    } else {
      each_image_beside([&](const vec3& shift) {
        own_.near(home - shift, within,
                  [&](std::uint32_t n) { return look(own_items_[n], shift); });
      });
    }
  }
  /// Calls f(centre, hit) for the own finite bodies, or the global ones, that a filter lets
  /// through.
  template <class F>
  void each(bool global, const query_filter& filter, F&& f) {
    for (const item& one : global ? global_items_ : own_items_)
      visit(one, global, question{}, filter,
            [&](const auto&, const pose& at, const query_hit& of) { f(at.position, of); });
  }
  /// Whether a filter lets a body through.
  template <class Store>
  [[nodiscard]] static bool passes(const Store& store, std::size_t i, bool global,
                                   const query_filter& f) {
    if (!(global || store.fixed(i) ? f.fixed : f.movable)) return false;
    if constexpr (Store::template has<contact_groups>)
      return f.groups == ~std::uint32_t{0} ||
             (store.template column<contact_groups>()[i] & f.groups) != 0;
    return true;
  }

 private:
  template <class Store>
  void add(const Store& store, std::size_t count, std::uint32_t kind, bounds_tree& tree,
           std::vector<item>& items) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto& shape = store.shape[i];
      const pose at = pose_of(store, i);
      vec3 half = thrice<real>(shape.bounding_radius());
      if constexpr (concepts::convex_shape<typename Store::shape_type>)
        half = half.cwiseMin(shape.half_extents(at));
      tree.add(at.position, half);
      items.push_back({kind, static_cast<std::uint32_t>(i)});
    }
  }
  /// With the image in the box of a body that the user has moved out of it.
  template <class Store>
  [[nodiscard]] pose pose_of(const Store& store, std::size_t i) const {
    pose at = store.pose(i);
    if constexpr (Store::shape_type::finite && periodic)
      if (i < store.locals) at.position = wrapped(at.position);
    return at;
  }
  template <class F>
  void store_of(const item& one, bool global, F&& f) const {
    std::uint32_t kind = 0;
    s_.each_shape([&](const auto& b) {
      if (kind++ == one.kind) f(global ? b.global : b.movable);
    });
  }
  template <class F>
  void visit(const item& one, bool global, const question& q, const query_filter& filter, F&& f) {
    store_of(one, global, [&](const auto& store) {
      const std::size_t i = one.index;
      if (store.id[i] == q.except || !passes(store, i, global, filter)) return;
      query_hit of;
      of.id = store.id[i], of.kind = static_cast<int>(one.kind), of.global = global;
      f(store.shape[i], pose_of(store, i), of);
    });
  }
  template <class Take>
  [[nodiscard]] static real put(query_hit& of, const surface_hit& hit, const vec3& shift,
                                const Take& take, real length) {
    if (!hit.found()) return length;
    of.distance = hit.distance, of.point = hit.point + shift, of.normal = hit.normal;
    of.inside = hit.inside;
    return take(of);
  }

  const state_type& s_;
  bounds_tree own_, global_;
  std::vector<item> own_items_, global_items_, endless_;
};

}  // namespace detail
}  // namespace talus
