// expects: world.add takes a shape with its material: write world.add(shape, material, position)
// long
#include "talus/parallel/serial.hpp"
#include "talus/shape/plane.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere, plane>, transport<serial>>;

void set_up(world<scene>& world) {
  const auto stone = world.material({.density = 2.8});
#ifdef TALUS_CONTROL
  world.global([&](auto& scope) { scope.add(plane{}, stone); });
#else
  (void)stone;
  world.global([&](auto& scope) { scope.add(plane{}); });
#endif
}

int main() {}
