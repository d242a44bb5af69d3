// expects: world.drive takes a motion: a function of the time that returns a rigid_displacement
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

void set_up(world<scenario<transport<serial>, features<driven>>>& w, handle<plane> wall) {
#ifdef TALUS_CONTROL
  w.drive(wall, [](real t) { return rigid_displacement{.shift = {t, 0, 0}}; });
#else
  w.drive(wall, [](real t) { return vec3(t, 0, 0); });
#endif
}

int main() {}
