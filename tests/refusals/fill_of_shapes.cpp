// expects: a body is added, and this type is not one: write body{.shape = sphere{0.5}, .position =
// long
#include "talus/parallel/serial.hpp"
#include "talus/scene/lattice.hpp"
#include "talus/shape/plane.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere, plane>, transport<serial>>;

void set_up(world<scene>& world) {
  const auto stone = world.material({.density = 2.8});
#ifdef TALUS_CONTROL
  const auto sites = simple_cubic{.spacing = 1} & box_region{{0, 0, 0}, {4, 4, 4}};
  world.fill(sites, [&](const site& place) {
    return body{.shape = sphere{0.4}, .position = place.position, .material = stone};
  });
#else
  const auto sites = simple_cubic{.spacing = 1} & box_region{{0, 0, 0}, {4, 4, 4}};
  world.fill(sites, [&](const site&) { return stone, sphere{0.4}; });
#endif
}

int main() {}
