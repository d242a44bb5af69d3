// expects: world.decompose({...}) of hexagonal cells takes the fields rings, spacing, width, centre,
// axis and start, in this order
#include "talus/parallel/hexagonal.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

void set_up(world<scenario<transport<serial>, decomposition<hexagonal<dynamic>>>>& world) {
#ifdef TALUS_CONTROL
  world.decompose({.spacing = 2});
#else
  world.decompose({.size = 2});
#endif
}

int main() {}
