// expects: this scenario has no bodies of this shape
// expects: box
// within: 5 lines
// long
#include "talus/parallel/serial.hpp"
#include "talus/shape/box.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>, transport<serial>>;

void set_up(world<scene>& world) {
  const auto stone = world.material({.density = 2.8});
#ifdef TALUS_CONTROL
  world.add(sphere{0.5}, stone);
#else
  world.add(box{{1, 1, 1}}, stone);
#endif
}

int main() {}
