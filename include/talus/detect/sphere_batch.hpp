#pragma once
// Contacts of pairs of spheres, eight at a time. The numbers of a pair do not depend on the others
// and are those of the functions of single pairs, to the bit.
#include <array>
#include <cstddef>

#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/pack_vector.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// What detection reads of a sphere, in rows as large as four numbers; written once per step.
struct alignas(32) moving_sphere {
  vec3 position{0, 0, 0};
  real reach = 0;
  vec3 velocity{0, 0, 0};
  real radius = 0;
  vec3 spin{0, 0, 0};
  system_id id = no_id;
};

/// What the geometry of a contact depends on, in one row.
struct alignas(32) placed_sphere {
  vec3 position{0, 0, 0};
  real radius = 0;
};

/// The geometry of pairs of spheres.
template <class Pack>
struct sphere_geometry {
  Pack squared;              ///< distance of the centres, squared
  pack_vector<Pack> normal;  ///< from b to a
  Pack gap;
  pack_vector<Pack> lever_a, lever_b;  ///< from the centres to the contact
  Pack arm_a, arm_b;                   ///< distances of the contact from the centres

  [[gnu::always_inline]] inline sphere_geometry(const pack_vector<Pack>& a, const Pack& radius_a,
                                                const pack_vector<Pack>& b, const Pack& radius_b) {
    const Pack zero = every_lane<Pack>(0), one = every_lane<Pack>(1);
    const pack_vector<Pack> d = a - b;
    squared = dot(d, d);
    const Pack distance = square_root(squared), inverse = one / distance;
    const auto apart = squared > every_lane<Pack>(1e-200);  // else along z
    normal = {apart ? inverse * d.x : zero, apart ? inverse * d.y : zero,
              apart ? inverse * d.z : one};
    gap = distance - (radius_a + radius_b);
    const Pack half = every_lane<Pack>(0.5) * gap;
    const pack_vector<Pack> point = b + (radius_b + half) * normal;
    lever_a = point - a, lever_b = point - b;
    arm_a = -dot(normal, lever_a);
    arm_b = dot(normal, lever_b);
  }
};
/// Surfaces that are nearer than this part of their slack at the start of a step touch.
inline constexpr real touching_part = 0.01;

/// This part of both radii, or of the smaller one twice.
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack slack_of(const Pack& part, const Pack& radius_a,
                                                          const Pack& radius_b) {
  const Pack difference = radius_a - radius_b;
  const Pack excess = part * (difference < Pack{} ? -difference : difference);
  return part * radius_a + (part * radius_b - excess);
}

/// Up to eight pairs, added one by one, and their contacts.
class sphere_batch {
  using wide = wide_pack<real>;

 public:
  static constexpr unsigned capacity = lanes_of<wide>;

  /// A contact has a gap of at most `margin`; one with a gap above `slack` must be about to close.
  void set(unsigned lane, const moving_sphere& a, const moving_sphere& b, real margin, real slack) {
    set(lane, a, b);
    margin_[lane] = margin, slack_[lane] = slack;
  }
  /// Sets the spheres of a lane for collide_in_reach(), which computes margin and slack itself.
  void set(unsigned lane, const moving_sphere& a, const moving_sphere& b) {
    a_[lane] = &a, b_[lane] = &b;
  }
  /// Computes the contacts of the first `count` pairs. Bit k is set if pair k has one.
  [[nodiscard]] unsigned collide(unsigned count, real gravity, real dt) {
    return collide(
        count, gravity, dt,
        [](auto&&...) __attribute__((always_inline)) { return mask_of<wide>{}; });
  }
  /// Computes the contacts of the first `count` pairs. The margin of a pair is the sum of the
  /// reaches of both spheres beyond their radii, and its slack is the part `slack_part` of the
  /// smaller radius for each sphere. Bit k is set if pair k has a contact.
  [[nodiscard]] unsigned collide_in_reach(unsigned count, real gravity, real dt, real slack_part) {
    const wide part = every_lane<wide>(slack_part);
    return collide(
        count, gravity, dt,
        [&](const wide& reach_a, const wide& radius_a, const wide& reach_b, const wide& radius_b,
            const wide& squared) __attribute__((always_inline)) {
          const wide difference = radius_a - radius_b;
          const wide excess = part * (difference < wide{} ? -difference : difference);
          margin_ = (reach_a - radius_a) + (reach_b - radius_b) - excess;
          slack_ = part * radius_a + (part * radius_b - excess);
          const wide reach = reach_a + reach_b;
          return squared > reach * reach;
        });
  }

  /// The contacts of these pairs a time before, if the spheres had their present velocities.
  struct earlier_contacts {
    pack_vector<wide> normal, velocity;
    wide gap;
  };
  [[nodiscard]] [[gnu::always_inline]] inline earlier_contacts before(real dt) const {
    const auto place_a = rows(a_, &moving_sphere::position);
    const auto place_b = rows(b_, &moving_sphere::position);
    const auto motion_a = rows(a_, &moving_sphere::velocity);
    const auto motion_b = rows(b_, &moving_sphere::velocity);
    const auto spin_a = rows(a_, &moving_sphere::spin);
    const auto spin_b = rows(b_, &moving_sphere::spin);
    const wide back = every_lane<wide>(dt);
    const sphere_geometry<wide> x(vectors_in(place_a) - back * vectors_in(motion_a), motion_a.w,
                                  vectors_in(place_b) - back * vectors_in(motion_b), motion_b.w);
    auto u = vectors_in(motion_a) + crossed(vectors_in(spin_a), x.lever_a);
    u -= vectors_in(motion_b) + crossed(vectors_in(spin_b), x.lever_b);
    return {x.normal, u, x.gap};
  }
  /// The speed of the centres against each other, and those of both surfaces about them.
  [[nodiscard]] [[gnu::always_inline]] inline wide speed() const {
    const auto motion_a = rows(a_, &moving_sphere::velocity);
    const auto motion_b = rows(b_, &moving_sphere::velocity);
    const auto spin_a = vectors_in(rows(a_, &moving_sphere::spin));
    const auto spin_b = vectors_in(rows(b_, &moving_sphere::spin));
    const auto v = vectors_in(motion_a) - vectors_in(motion_b);
    return motion_a.w * square_root(dot(spin_a, spin_a)) +
           motion_b.w * square_root(dot(spin_b, spin_b)) + square_root(dot(v, v));
  }
  [[nodiscard]] const wide& margin() const { return margin_; }
  [[nodiscard]] const wide& slack() const { return slack_; }
  [[nodiscard]] [[gnu::always_inline]] inline wide smaller_radius() const {
    return smaller(rows(a_, &moving_sphere::velocity).w, rows(b_, &moving_sphere::velocity).w);
  }

  pack_vector<wide> normal;    ///< from b to a
  pack_vector<wide> velocity;  ///< of a against b at the contact
  wide gap;
  wide approach;       ///< the velocity along the normal
  wide arm_a, arm_b;   ///< distances of the contact from the centres
  unsigned apart = 0;  ///< the lanes whose surfaces do not touch yet: they may pass each other

 private:
  [[nodiscard]] [[gnu::always_inline]] static inline pack_rows<wide> rows(
      const std::array<const moving_sphere*, capacity>& of, vec3 moving_sphere::*part) {
    return gather<wide>([&](int k) __attribute__((always_inline)) {
      const moving_sphere& x = *of[static_cast<std::size_t>(k)];
      return row_of(x, x.*part);
    });
  }
  /// `find_margins` may set the margins and slacks; the mask that it returns excludes pairs.
  template <class FindMargins>
  [[nodiscard]] [[gnu::always_inline]] inline unsigned collide(unsigned count, real gravity,
                                                               real dt,
                                                               FindMargins&& find_margins) {
    for (unsigned k = count; k < capacity; ++k) a_[k] = a_[0], b_[k] = b_[0];
    const auto place_a = rows(a_, &moving_sphere::position);
    const auto place_b = rows(b_, &moving_sphere::position);
    const auto motion_a = rows(a_, &moving_sphere::velocity);
    const auto motion_b = rows(b_, &moving_sphere::velocity);
    const auto spin_a = rows(a_, &moving_sphere::spin);
    const auto spin_b = rows(b_, &moving_sphere::spin);

    const sphere_geometry<wide> x(vectors_in(place_a), motion_a.w, vectors_in(place_b), motion_b.w);
    normal = x.normal, gap = x.gap, arm_a = x.arm_a, arm_b = x.arm_b;
    const auto excluded = find_margins(place_a.w, motion_a.w, place_b.w, motion_b.w, x.squared);
    const wide reach = motion_a.w + motion_b.w + margin_;
    velocity = vectors_in(motion_a) + crossed(vectors_in(spin_a), x.lever_a);
    velocity -= vectors_in(motion_b) + crossed(vectors_in(spin_b), x.lever_b);
    approach = dot(normal, velocity);
    const wide closing = approach * dt - every_lane<wide>(2 * gravity * dt * dt);
    const auto near = x.squared <= reach * reach;
    const auto left_out = excluded | ((gap > slack_) & (gap + closing > slack_));
    const unsigned met = bits_of(both(near, inverted(left_out))) & ((1u << count) - 1);
    apart = met & bits_of(gap > every_lane<wide>(touching_part) * slack_);
    return met;
  }

  std::array<const moving_sphere*, capacity> a_, b_;
  wide margin_{}, slack_{};
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
