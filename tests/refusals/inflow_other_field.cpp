// expects: insert_by_rate(world, {...}, region, make) takes the fields bodies, mass, from, most,
// tries and name
#include "talus/parallel/serial.hpp"
#include "talus/scene/inflow.hpp"
#include "talus/world/world.hpp"
using namespace talus;

template <class World>
void set_up(World& world) {
  const auto make = [](const site& place, random_stream&) {
    return body{.shape = sphere{0.5}, .position = place.position};
  };
#ifdef TALUS_CONTROL
  insert_by_rate(world, {.bodies = 20}, box_region{{0, 0, 0}, {1, 1, 1}}, make);
#else
  insert_by_rate(world, {.rate = 20}, box_region{{0, 0, 0}, {1, 1, 1}}, make);
#endif
}
template void set_up(world<scenario<transport<serial>>>&);

int main() {}
