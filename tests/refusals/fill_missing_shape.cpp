// expects: this scenario has no bodies of this shape
// expects: box
// within: 5 lines
// long
#include "talus/parallel/serial.hpp"
#include "talus/scene/lattice.hpp"
#include "talus/shape/box.hpp"
#include "talus/world/world.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>, transport<serial>>;

void set_up(world<scene>& world) {
  const auto sites = simple_cubic{.spacing = 1} & box_region{{0, 0, 0}, {4, 4, 4}};
  world.fill(sites.first(3), [&](const site& place, random_stream&) {
    std::optional<std::variant<body<sphere>>> made =
        body{.shape = sphere{0.4}, .position = place.position};
    return made;
  });
#ifdef TALUS_CONTROL
  world.fill(sites, [&](const site& place) {
    return body{.shape = sphere{0.4}, .position = place.position};
  });
#else
  world.fill(sites, [&](const site& place) {
    std::optional<std::variant<body<sphere>, body<box>>> made =
        body{.shape = sphere{0.4}, .position = place.position};
    return made;
  });
#endif
}

int main() {}
