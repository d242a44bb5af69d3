// expects: world.material_pair(a, b, {...}) takes the fields restitution, friction,
// dynamic_friction and cohesion, in this order
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

void set_up(world<scenario<transport<serial>>>& world) {
  const auto stone = world.material({.density = 2.8});
#ifdef TALUS_CONTROL
  world.material_pair(stone, stone, {.friction = 0.25});
#else
  world.material_pair(stone, stone, {.roughness = 0.25});
#endif
}

int main() {}
