// expects: talus calls superquadrics superellipsoid, with radii and the exponents n1 and n2 from 2 to 8: write
// superellipsoid, see docs/policies/shapes.md
// within: 5 lines
#include "talus/body/bodies.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/sphere.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using parts = bodies<sphere, box>;
#else
using parts = bodies<sphere, superquadric>;
#endif

const parts checked;

int main() {}
