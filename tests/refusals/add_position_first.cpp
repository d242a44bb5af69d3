// expects: world.add takes the material before the position: write world.add(shape, material, position)
// long
#include "talus/parallel/serial.hpp"
#include "talus/scene/lattice.hpp"
#include "talus/shape/plane.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere, plane>, transport<serial>>;

void set_up(world<scene>& world) {
  const auto stone = world.material({.density = 2.8});
#ifdef TALUS_CONTROL
  world.add(sphere{1}, stone, {0, 0, 1});
#else
  world.add(sphere{1}, {0, 0, 1}, stone);
#endif
}

int main() {}
