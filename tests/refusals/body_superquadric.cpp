// expects: superquadric
// expects: superellipsoid
// within: 5 lines
#include "talus/body/body.hpp"
#include "talus/core/policy.hpp"
#include "talus/shape/sphere.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const auto egg = body{.shape = sphere{.radius = 2}};
#else
const auto egg = body{.shape = superquadric{.radii = {1, 1, 2}}};
#endif

int main() {}
