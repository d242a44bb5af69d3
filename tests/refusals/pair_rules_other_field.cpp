// expects: world.pair_rules({...}) takes the fields restitution and friction, in this order
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

template <class World>
void set_up(World& world) {
#ifdef TALUS_CONTROL
  world.pair_rules({.friction = pair_rule::least});
#else
  world.pair_rules({.frcition = pair_rule::least});
#endif
}
template void set_up(world<scenario<transport<serial>>>&);

int main() {}
