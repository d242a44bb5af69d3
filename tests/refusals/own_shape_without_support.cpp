// expects: a shape of bodies<...> has no support function: give it vec3 support(const vec3& direction) const
#include "talus/scenario/scenario.hpp"
using namespace talus;

struct lens {
  real radius = 1;
  static constexpr bool finite = true, isotropic = false;
  static constexpr const char* name = "lens";
  void validate() const {}
  [[nodiscard]] real bounding_radius() const { return radius; }
  [[nodiscard]] real volume() const { return radius; }
  [[nodiscard]] vec3 inertia() const { return {1, 1, 1}; }
  [[nodiscard]] vec3 half_extents(const pose&) const { return {radius, radius, radius}; }
#ifdef TALUS_CONTROL
  [[nodiscard]] vec3 support(const vec3& d) const { return radius * unit(d); }
#endif
  friend bool operator==(const lens&, const lens&) = default;
};
using scene = scenario<bodies<lens, plane>>;

const scene checked;

int main() {}
