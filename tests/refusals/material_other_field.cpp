// expects: world.material({...}) takes the fields density, restitution, friction, dynamic_friction,
// stiffness, youngs_modulus, poisson_ratio
#include "talus/parallel/serial.hpp"
#include "talus/world/world.hpp"
using namespace talus;

template <class World>
void set_up(World& world) {
#ifdef TALUS_CONTROL
  world.material({.density = 2.8, .friction = 0.25});
#else
  world.material({.density = 2.8, .frcition = 0.25});
#endif
}
template void set_up(world<scenario<transport<serial>>>&);

int main() {}
