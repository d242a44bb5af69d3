// expects: fill takes sites, and this type is not one: a bare lattice has no end, so write lattice &
// region
#include "talus/scene/lattice.hpp"

using namespace talus;

void visit(const vec3& lower, const vec3& upper) {
#ifdef TALUS_CONTROL
  const auto sites = simple_cubic{.spacing = 2} & box_region{{0, 0, 0}, {9, 9, 9}};
#else
  const simple_cubic sites{.spacing = 2};
#endif
  for_each_site(
      sites, lower, upper, [](const vec3&) { return true; }, [](const site&) {});
}

int main() {}
