// expects: two shapes of bodies<...> have the same name, by which files distinguish them
#include "talus/scenario/scenario.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/shape/union_of.hpp"
using namespace talus;

struct pebble : sphere {
#ifdef TALUS_CONTROL
  static constexpr const char* name = "pebble";
#endif
};

using scene = scenario<bodies<pebble, sphere, union_of<sphere>, union_of<sphere, pebble>>>;

const scene checked;

int main() {}
