#pragma once
// The area in which a body touches fixed bodies that lie flush beside each other: points on the
// seams between them are no corners of that area, and would add to the stiffness of soft contacts.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "talus/contact/contact_geometry.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/detect/collide_pair.hpp"
#include "talus/detect/level_patches.hpp"
#include "talus/pairs/filtered_pairs.hpp"
#include "talus/pairs/flush_surface.hpp"
#include "talus/shape/plane.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Whether bodies of a movable shape have seams to cross on those of a fixed one.
template <class Scenario, class Fixed, class Other>
inline constexpr bool may_cross_seams =
    world_state<Scenario>::may_be_flush&& is_solid_beside<Fixed> && !Other::isotropic;

/// Drops contacts of the movable body l, which is at `at` among the fixed ones, with the fixed body
/// of this number.
template <class Scenario, class Other>
class flush_corners {
  using state_type = world_state<Scenario>;
  using store_type = body_store<Other, typename Scenario::features>;

 public:
  flush_corners(state_type& s, std::uint32_t number, const store_type& other, std::size_t l,
                const pose& at, real range)
      : s_(s),
        number_(number),
        other_(other),
        l_(l),
        at_(at),
        range_(range),
        size_(other.shape[l].bounding_radius()),
        radius_(s.flush.all[number].radius) {}

  /// Leaves those that are corners of the area in which the body touches all fixed bodies that are
  /// flush there. Of bodies that have the same corner, that with the smaller id keeps it.
  void leave(plain_vector<contact_geometry>& own) {
    const auto& f = s_.flush;
    plain_vector<std::uint32_t> all;
    f.each_near(number_, at_.position, size_ + range_, [&](std::uint32_t other) {
      if (may_touch_it(other) && moves_alike(other)) all.push_back(other);
      return true;
    });
    if (own.empty() || all.empty()) return;
    for (const std::uint32_t other : all) find(other);
    drop_cuts(own);
    if (others_.empty()) return;
    const plain_vector<contact_geometry> before = own;
    plain_vector<contact_geometry> corners;
    std::size_t kept = 0;
    for (const contact_geometry& c : before) {
      if (&c == before.data() || part_of(c) != part_of((&c)[-1])) find_corners(before, c, corners);
      if (is_at(c, corners, false) && !is_at(c, others_, true)) own[kept++] = c;
    }
    own.resize(kept);
  }

 private:
  struct found_contact : contact_geometry {
    std::uint32_t number = 0;  ///< of its body
    bool first = false;        ///< that has a smaller id
  };

  /// Drops the contacts on seams that stand for no corner of the movable body.
  void drop_cuts(plain_vector<contact_geometry>& own) {
    plain_vector<contact_geometry> all = own;
    for (const contact_geometry& c : others_) all.push_back(c);
    const auto drop = [&](auto& list, const auto& number_of) {
      std::size_t kept = 0;
      for (const auto& c : list)
        if (!is_cut(number_of(c), c, all)) list[kept++] = c;
      list.resize(kept);
    };
    drop(own, [&](const contact_geometry&) { return number_; });
    drop(others_, [](const found_contact& c) { return c.number; });
  }
  [[nodiscard]] bool is_cut(std::uint32_t number, const contact_geometry& c,
                            const plain_vector<contact_geometry>& all) {
    if constexpr (!collidable<Other, plane>) return false;
    bool cut = false;
    with_flush_body(s_, number, [&](const auto& store, std::size_t k) {
      using fixed = typename std::remove_cvref_t<decltype(store)>::shape_type;
      with_flush_surface<fixed, Other>(s_, store, k, store.position[k], s_.flush.all[number].global,
                                       other_, l_, at_.position, on_surface(c), c.normal,
                                       [&](auto& surface, std::uint32_t one) {
                                         cut = surface.is_on_seam(one, beside_part * size_);
                                       });
    });
    if (!cut) return false;
    const plane level{c.normal, c.normal.dot(on_surface(c))};
    collide_pair(other_.shape[l_], at_, level, pose{}, range_, [&](const contact_geometry& corner) {
      cut = cut && !(corner.gap < range_ && stands_for(corner, c, all));
    });
    return cut;
  }
  /// Whether c is the contact for a corner on the plane of the surface. A body with a fixed one
  /// that it reaches by less than its overlap has a contact sideways instead.
  [[nodiscard]] bool stands_for(const contact_geometry& corner, const contact_geometry& c,
                                const plain_vector<contact_geometry>& all) const {
    const auto distance = [&](const contact_geometry& other) {
      return part_of(other) == part_of(corner) ? (on_body(other) - on_body(corner)).norm()
                                               : std::numeric_limits<real>::infinity();
    };
    const real far = distance(c);
    return far <= real(2e-6) * size_ + std::abs(c.gap) &&
           std::none_of(all.begin(), all.end(), [&](const contact_geometry& other) {
             return distance(other) < far - real(1e-9) * size_ &&
                    other.normal.dot(c.normal) > real(0.99);
           });
  }
  [[nodiscard]] bool may_touch_it(std::uint32_t number) const {
    bool may = true;
    if constexpr (state_type::filters)
      with_flush_body(s_, number, [&](const auto& store, std::size_t k) {
        may = may_touch(s_, other_, l_, store, k);
      });
    return (void)number, may;
  }
  /// Whether that body moves like this one under the movable body.
  [[nodiscard]] bool moves_alike(std::uint32_t number) const {
    if constexpr (!state_type::drives) return (void)number, true;
    const auto speed = [&](std::uint32_t one) {
      vec3 v(0, 0, 0);
      with_flush_body(s_, one, [&](const auto& store, std::size_t k) {
        v = store.velocity[k] +
            store.angular_velocity[k].cross(vec3(at_.position - store.position[k]));
      });
      return v;
    };
    return (speed(number) - speed(number_)).norm() * s_.dt <= flush_part * size_;
  }
  /// The contacts with another fixed body.
  void find(std::uint32_t number) {
    radius_ = std::max(radius_, s_.flush.all[number].radius);
    with_flush_body(s_, number, [&](const auto& store, std::size_t k) {
      using fixed = typename std::remove_cvref_t<decltype(store)>::shape_type;
      if constexpr (collidable<Other, fixed>) {
        const bool first = s_.flush.all[number].id < s_.flush.all[number_].id;
        collide_pair(other_.shape[l_], at_, store.shape[k], store.pose(k), range_,
                     [&](const contact_geometry& c) {
                       if (c.gap < range_ &&
                           !is_hidden_on<fixed, Other>(s_, store, k, store.position[k],
                                                       s_.flush.all[number].global, other_, l_,
                                                       at_.position, on_surface(c), c.normal))
                         others_.push_back({c, number, first});
                     });
      }
    });
  }
  /// The corners of the areas of one part of the body, with all of the fixed bodies.
  void find_corners(const plain_vector<contact_geometry>& own, const contact_geometry& one,
                    plain_vector<contact_geometry>& corners) const {
    level_patches level(size_, flush_part / weld_part * radius_);
    corners.clear();
    const auto add = [&](const contact_geometry& c) {
      if (part_of(c) == part_of(one) &&
          !level.add(c, c.normal, c.normal.dot(on_surface(c) - at_.position)))
        corners.push_back(c);
    };
    for (const contact_geometry& c : own) add(c);
    for (const contact_geometry& c : others_) add(c);
    level.each([&](const contact_geometry& c) { corners.push_back(c); });
  }
  /// Whether one of the contacts is at the place of this one.
  template <class Contact>
  [[nodiscard]] bool is_at(const contact_geometry& c, const plain_vector<Contact>& all,
                           bool only_first) const {
    return std::any_of(all.begin(), all.end(), [&](const Contact& other) {
      if constexpr (std::is_same_v<Contact, found_contact>)
        if (only_first && !other.first) return false;
      return part_of(other) == part_of(c) && is_near(other, c) &&
             other.normal.dot(c.normal) > real(0.99);
    });
  }
  [[nodiscard]] bool is_near(const contact_geometry& a, const contact_geometry& b) const {
    const real near = real(2e-6) * size_;
    return (a.point - b.point).squaredNorm() <= near * near;
  }
  [[nodiscard]] static vec3 on_body(const contact_geometry& c) {
    return c.point + real(0.5) * c.gap * c.normal;
  }
  [[nodiscard]] static vec3 on_surface(const contact_geometry& c) {
    return c.point - real(0.5) * c.gap * c.normal;
  }
  /// The part of a body that is a union.
  [[nodiscard]] static std::uint64_t part_of(const contact_geometry& c) {
    return c.feature >> 32 & 0xffff;
  }

  /// How far beside a contact the surface goes on there, as a part of the radius of the body.
  static constexpr real beside_part = 1e-4;

  state_type& s_;
  std::uint32_t number_;
  const store_type& other_;
  std::size_t l_;
  pose at_;
  real range_, size_;
  real radius_;  ///< the largest of the fixed bodies
  plain_vector<found_contact> others_;
};

/// Drops those contacts of bodies i and j, at p_a and p_b for this pair, which are no corners of
/// the area in which the movable one touches flush bodies.
template <class ShapeA, class ShapeB, bool Paired, class Scenario, class StoreA, class StoreB>
[[gnu::noinline]] void leave_corners(world_state<Scenario>& s, const StoreA& a, std::size_t i,
                                     const pose& p_a, const StoreB& b, std::size_t j,
                                     const pose& p_b, real range,
                                     plain_vector<contact_geometry>& own) {
  const auto leave = [&]<class Fixed, class Other>(const auto& fixed, std::size_t k, const vec3& at,
                                                   bool global, const auto& other, std::size_t l,
                                                   pose there) {
    const std::int32_t number = number_if_flush<Fixed>(s, global, k);
    if (number < 0) return;
    const vec3 image = fixed.position[k] - at;  // where the pair is among the others
    there.position += image;
    const auto move = [&](const vec3& by) {
      for (contact_geometry& c : own) c.point += by;
    };
    move(image);
    flush_corners<Scenario, Other>(s, static_cast<std::uint32_t>(number), other, l, there, range)
        .leave(own);
    move(-image);
  };
  if constexpr (may_cross_seams<Scenario, ShapeB, ShapeA>)
    if (!Paired || b.inverse_mass[j] == 0)
      return leave.template operator()<ShapeB, ShapeA>(b, j, p_b.position, !Paired, a, i, p_a);
  if constexpr (Paired && may_cross_seams<Scenario, ShapeA, ShapeB>)
    if (a.inverse_mass[i] == 0) {
      for (contact_geometry& c : own) c = c.swapped();
      leave.template operator()<ShapeA, ShapeB>(a, i, p_a.position, false, b, j, p_b);
      for (contact_geometry& c : own) c = c.swapped();
    }
}

}  // namespace talus::detail
