// expects: this scenario has no bodies of this shape
// expects: box
// within: 5 lines
// long
#include "talus/observe/force.hpp"
#include "talus/observe/loads.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/shape/box.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>, transport<serial>>;

void look(world<scene>& world) {
#ifdef TALUS_CONTROL
  (void)measure_body(world, handle<sphere>{});
#else
  (void)measure_body(world, handle<box>{});
#endif
}

int main() {}
