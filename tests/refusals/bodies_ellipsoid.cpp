// expects: talus has no ellipsoids: docs/not_there.md says what to take instead
#include "talus/body/bodies.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/sphere.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using parts = bodies<sphere, box>;
#else
using parts = bodies<sphere, ellipsoid>;
#endif

const parts checked;

int main() {}
