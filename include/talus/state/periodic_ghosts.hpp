#pragma once
// Shadow copies that are images of a periodic box: their owner has them at another place, perhaps
// here.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/type_list.hpp"
#include "talus/parallel/periodic_box.hpp"

namespace talus::detail {

/// Shadow copies as their owner lists them: the body, and its image. In the order of the bodies;
/// without periodic axes, the index of the body.
template <bool Periodic>
struct copy_code {
  static constexpr std::uint32_t images = Periodic ? 32 : 1;

  [[nodiscard]] static constexpr std::uint32_t of(std::size_t body, std::uint32_t image) {
    return static_cast<std::uint32_t>(body) * images + image;
  }
  [[nodiscard]] static constexpr std::uint32_t body(std::uint32_t code) { return code / images; }
  [[nodiscard]] static constexpr std::uint32_t image(std::uint32_t code) { return code % images; }
};

/// The data of a shadow copy besides its pose.
struct image_copy {
  vec3 home{0, 0, 0};  ///< the position of the body at its owner
  periodic_box::number image = 0;
  std::uint32_t own = not_own;  ///< the body itself, if it is owned here

  static constexpr std::uint32_t not_own = 0xffffffffu;
};
/// The data of all shadow copies, by shape, in the order of the copies.
template <std::size_t Shapes>
struct periodic_ghosts {
  std::array<plain_vector<image_copy>, Shapes> of;
};
struct no_periodic_ghosts {};

/// The nearest image of a position, seen from another one, if there are images.
template <class State>
[[nodiscard]] vec3 seen_from(const State& s, const vec3& place, const vec3& thing) {
  if constexpr (State::periodic) return s.own.box().nearest(thing, place);
  return (void)s, (void)place, thing;
}

/// The data of a body as a shadow copy, or null.
template <class Shape, class State>
[[nodiscard]] auto* copy_of(State& s, std::size_t i) {
  const std::size_t locals = s.template of<Shape>().movable.locals;
  auto& copies = s.copies.of[index_of<typename State::finite_shapes, Shape>];
  return i < locals ? nullptr : &copies[i - locals];
}

/// Whether this rank holds at most one image of each body, and all images of an island on the same
/// side of the box: its domain and the reach around it are shorter than each period. True without
/// periodic axes.
template <class State>
[[nodiscard]] bool sees_single_images(const State& s) {
  if constexpr (State::periodic) {
    const auto* cells = s.own.partition();
    if (cells == nullptr) return false;
    real reach = s.choice.announced;
    for (const auto& n : s.neighbours) reach = std::max(reach, n.reach);
    const auto cell = cells->cell(s.own.rank());
    const vec3& period = s.own.box().period();
    for (int k = 0; k < 3; ++k)
      if (period[k] > 0 && cell.upper[k] - cell.lower[k] + 4 * reach > period[k]) return false;
  }
  return (void)s, true;
}

/// A pair of bodies in the same coordinates on all ranks, to the bit, on whichever side of the box
/// they are: the first one at its own position, and the second one at its minimum image.
struct image_pair {
  vec3 a{0, 0, 0}, b{0, 0, 0};
  std::size_t body_b =
      0;              ///< the index of the second one; of the body itself, not of its image here
  bool known = true;  ///< false: an image of a body owned here, with which the pair is found too
};
template <class A, class B, class State>
[[nodiscard]] image_pair minimum_image(const State& s, std::size_t i, std::size_t j) {
  image_pair pair{s.template of<A>().movable.position[i], s.template of<B>().movable.position[j],
                  j};
  if (const image_copy* a = copy_of<A>(s, i); a != nullptr && a->image != 0) {
    pair.a = a->home;
    pair.b += s.own.box().shift(periodic_box::reverse(a->image));
    pair.known = a->own == image_copy::not_own;
  } else if (const image_copy* b = copy_of<B>(s, j);
             b != nullptr && b->own != image_copy::not_own) {
    pair.body_b = b->own;
    pair.known = i < s.template of<A>().movable.locals;
  }
  return pair;
}

}  // namespace talus::detail
