// expects: a shape that moves, or is to be placed, has a volume: pass a sphere, a box or another finite shape
// long
#include <array>

#include "talus/parallel/serial.hpp"
#include "talus/queries.hpp"
using namespace talus;

using scene = scenario<bodies<sphere, plane>, transport<serial>>;

void ask(world<scene>& world) {
  const std::array ways{shape_path{.from = {0, 0, 3}}};
#ifdef TALUS_CONTROL
  (void)cast_shape(world, sphere{0.5}, ways);
#else
  (void)cast_shape(world, plane{}, ways);
#endif
}

int main() {}
