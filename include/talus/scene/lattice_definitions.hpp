#pragma once
// The definitions of lattice.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/scene/lattice.hpp"

namespace talus {

TALUS_INLINE vec3 body_centred_cubic::shift(bool, bool odd_layer) const {
  const real s = odd_layer ? spacing / 2 : 0;
  return {s, s, 0};
}

TALUS_INLINE vec3 hexagonal_close_packed::step() const {
  return {spacing, spacing * std::sqrt(real(0.75)), spacing * std::sqrt(real(2) / 3)};
}

TALUS_INLINE vec3 hexagonal_close_packed::shift(bool odd_row, bool odd_layer) const {
  return {odd_row != odd_layer ? spacing / 2 : 0, odd_layer ? spacing / std::sqrt(real(12)) : 0, 0};
}

}  // namespace talus
