// expects: talus has no superquadrics: take a convex_polyhedron of points on the surface, or a union_of<sphere>, see
// docs/not_there.md
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
