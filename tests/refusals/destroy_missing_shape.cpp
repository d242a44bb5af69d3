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
#ifdef TALUS_CONTROL
  world.destroy(handle<sphere>{});
  (void)world[handle<sphere>{}].position();
  (void)world.find(handle<sphere>{});
#else
  world.destroy(handle<box>{});
#endif
}

int main() {}
