// expects: insert_by_rate takes a function that returns a body, or a std::variant of bodies of several
// long
#include "talus/parallel/serial.hpp"
#include "talus/scene/inflow.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>, transport<serial>>;

void set_up(world<scene>& world) {
  const box_region above{{0, 0, 4}, {4, 4, 6}};
#ifdef TALUS_CONTROL
  insert_by_rate(world, {.bodies = 10}, above, [](const site& place, random_stream& random) {
    return body{.shape = sphere{random.uniform(0.3, 0.4)}, .position = place.position};
  });
#else
  insert_by_rate(world, {.bodies = 10}, above, [](const site&, random_stream& random) {
    return sphere{random.uniform(0.3, 0.4)};
  });
#endif
}

int main() {}
