// expects: a handle is the number of a body: write world[handle].position() and the like
// long
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>, transport<serial>>;

real height(world<scene>& world, handle<sphere> ball) {
#ifdef TALUS_CONTROL
  return world[ball].position()[2];
#else
  (void)world;
  return ball.position()[2];
#endif
}

int main() {}
