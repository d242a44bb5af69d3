// expects: bodies<...> names a shape whose header is missing: write #include <talus/mesh.hpp>
#include "talus/scenario/scenario.hpp"
#ifdef TALUS_CONTROL
#include "talus/mesh.hpp"
#endif
using namespace talus;

using scene = scenario<bodies<sphere, triangle_mesh>>;

const scene checked;

int main() {}
