#pragma once
// Contacts of pairs of ellipsoids, several at a time.
#include <algorithm>
#include <array>
#include <cstddef>

#include "talus/contact/contact_geometry.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/detect/batch_of.hpp"
#include "talus/detect/detail/ellipsoid_climb.hpp"
#include "talus/detect/ellipsoid_place.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Pairs added one by one and computed together. The numbers of a pair do not depend on the others
/// and are those of the function of single pairs, to the bit.
template <class Real>
class ellipsoid_batch {
  using wide = wide_pack<Real>;

 public:
  using place = ellipsoid_place<Real>;
  static constexpr unsigned capacity = 32;

  /// The ellipsoids must stay where they are until the search.
  void set(unsigned k, const place& a, const place& b, Real margin) {
    pairs_[k] = {&a, &b, margin};
  }
  /// Bit k is set if pair k, of the first `count`, has a contact.
  [[nodiscard]] unsigned search(unsigned count) {
    // The first normal is enough for most of the pairs that are apart.
    unsigned near[capacity], size = 0;
    for (unsigned first = 0; first < count; first += lanes) {
      load(std::min(lanes, count - first), [&](unsigned k) { return first + k; });
      (void)climb_.begin();
      const unsigned left = bits_of(inverted(climb_.beyond));
      for (unsigned k = first; k < std::min(first + lanes, count); ++k) {
        near[size] = k;
        size += left >> (k - first) & 1u;
      }
    }
    unsigned met = 0;
    uncertain_ = 0;
    for (unsigned first = 0; first < size; first += lanes)
      met |= climb(near + first, std::min(lanes, size - first));
    return met;
  }
  /// Bit k is set if the function of single pairs has to compute pair k.
  [[nodiscard]] unsigned uncertain() const { return uncertain_; }
  /// The contact of a pair, if the centre of its first body is at `origin`.
  [[nodiscard]] contact_geometry contact(std::size_t k, const vector3<Real>& origin) const {
    const found& x = found_[k];
    return {x.normal, origin + x.middle, x.gap, 0};
  }

 private:
  static constexpr unsigned lanes = lanes_of<wide>;
  struct pair {
    const place *a, *b;
    Real margin;
  };
  struct found {
    vector3<Real> normal, middle;
    Real gap;
  };

  /// Sets the first `count` lanes to the pairs pair_of(lane), and the others to the last of them.
  template <class PairOf>
  [[gnu::always_inline]] inline void load(unsigned count, PairOf&& pair_of) {
    const pair* of[lanes];
    for (unsigned k = 0; k < lanes; ++k) of[k] = &pairs_[pair_of(std::min(k, count - 1))];
    const auto rows = [&](const place* pair::*which, vector3<Real> place::*part)
        __attribute__((always_inline)) {
      return gather<wide>([&](int k) __attribute__((always_inline)) {
        const place& x = *(of[k]->*which);
        return row_of(x, x.*part);
      });
    };
    const auto form = [&](const place* pair::*which, pack_matrix<wide>& m, wide& outer, wide& inner)
        __attribute__((always_inline)) {
      const auto x = rows(which, &place::first), y = rows(which, &place::further);
      m = {{x.x, x.y, x.z}, {x.y, y.x, y.y}, {x.z, y.y, y.z}};
      outer = x.w, inner = y.w;
    };
    form(&pair::a, climb_.a, outer_a_, inner_a_), form(&pair::b, climb_.b, outer_b_, inner_b_);
    climb_.apart = vectors_in(rows(&pair::b, &place::position));
    climb_.apart -= vectors_in(rows(&pair::a, &place::position));
    for (unsigned k = 0; k < lanes; ++k) climb_.limit[k] = of[k]->margin;
    climb_.smallest = smaller(inner_a_, inner_b_);
  }
  /// Finds the normals of these pairs; returns the bits of those with a contact.
  [[nodiscard]] unsigned climb(const unsigned* pairs, unsigned count) {
    load(count, [&](unsigned k) { return pairs[k]; });
    climb_.search();
    const wide most = certain_overlap(inner_a_, outer_a_, inner_b_, outer_b_);
    const auto certain = climb_.summit & (climb_.gap >= -most);
    const unsigned unknown = bits_of(inverted(climb_.beyond | certain));
    const unsigned touching = bits_of(certain & (climb_.gap <= climb_.limit));
    const auto middle = every_lane<wide>(0.5) * (climb_.on_a + climb_.on_b);
    unsigned met = 0;
    for (unsigned k = 0; k < count; ++k) {
      uncertain_ |= (unknown >> k & 1u) << pairs[k];
      met |= (touching >> k & 1u) << pairs[k];
      found_[pairs[k]] = {lane(climb_.normal, k), lane(middle, k), climb_.gap[k]};
    }
    return met;
  }

  std::array<pair, capacity> pairs_;
  std::array<found, capacity> found_;
  ellipsoid_climb<wide, false> climb_;
  wide outer_a_, inner_a_, outer_b_, inner_b_;
  unsigned uncertain_ = 0;
};

template <>
struct batch_of<ellipsoid> {
  using type = ellipsoid_batch<real>;
};
template <class Sink, class Real>
void collide_lane(const ellipsoid_place<Real>& a, const ellipsoid_place<Real>&,
                  const ellipsoid_batch<Real>& batch, unsigned lane, Real, Sink&& sink) {
  sink(batch.contact(lane, a.position));
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
