// expects: this scenario has no bodies of this shape
// expects: box
// within: 5 lines
// long
#include "talus/parallel/serial.hpp"
#include "talus/scene/inflow.hpp"
#include "talus/shape/box.hpp"
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
  insert_by_rate(world, {.bodies = 10}, above, [](const site& place, random_stream&) {
    return body{.shape = box{{1, 1, 1}}, .position = place.position};
  });
#endif
}

int main() {}
