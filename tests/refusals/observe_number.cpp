// expects: world.observe takes how often, and a function of the world: write
// long
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>, transport<serial>>;

void set_up(world<scene>& world) {
#ifdef TALUS_CONTROL
  world.observe(every{200}, [](auto& w) { (void)w.steps(); });
#else
  world.observe(200, [](auto& w) { (void)w.steps(); });
#endif
}

int main() {}
