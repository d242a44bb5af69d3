// expects: world.units({...}) takes the fields length, mass and time, in this order
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

template <class World>
void name_units(World& world) {
#ifdef TALUS_CONTROL
  world.units({.length = "m", .time = "s"});
  (void)world.units().length;
#else
  world.units({.length = "m", .seconds = "s"});
#endif
}
template void name_units(world<scenario<transport<serial>>>&);

int main() {}
