#pragma once
// The definitions of body_checks.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/world/body_checks.hpp"

namespace talus::detail {

TALUS_INLINE void require_finite(const char* what, const vec3& v) {
  if (!finite(v)) fail<std::invalid_argument>("{} must be finite, but is {}", what, text(v));
}

}  // namespace talus::detail
