// expects: set_motor of a joint takes torque_motor{...} for an angle, or force_motor{...} for a travel
#include "talus/constraint/hinge.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>, joints<hinge>, transport<serial>>;

void brake(joint_handle<scene, hinge>& pin) {
#ifdef TALUS_CONTROL
  pin.set_motor(torque_motor{.velocity = 0, .largest_torque = 50});
#else
  pin.set_motor({.speed = 0});
#endif
}

int main() {}
