// expects: an infinite body, such as a plane, is known on all ranks: add it in world.global(
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
  world.global([&](auto& scope) { scope.add(plane{}, stone); });
#else
  world.add_if_local(body{.shape = plane{}, .material = stone});
#endif
}

int main() {}
