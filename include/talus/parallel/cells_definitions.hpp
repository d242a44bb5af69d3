#pragma once
// The definitions of cells.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/cells.hpp"

namespace talus::detail {

TALUS_INLINE int first_containing(const std::vector<any_geometry>& regions, const vec3& p) {
  first_region first;
  for (const any_geometry& region : regions)
    if (first(region, p)) break;
  return first.position();
}

}  // namespace talus::detail
