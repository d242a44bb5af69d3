// expects: world.simulate({...}) takes the fields
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

template <class World>
void run_it(World& world) {
#ifdef TALUS_CONTROL
  world.simulate({.steps = 100, .dt = 0.01});
#else
  world.simulate({.steps = 100, .timestep = 0.01});
#endif
}
template void run_it(world<scenario<transport<serial>>>&);

int main() {}
