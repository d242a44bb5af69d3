// expects: union_of<...> takes shapes with a volume that are no unions themselves
// expects: instead of a triangle_mesh, which is a surface, add convex_polyhedron parts
#include <talus/mesh.hpp>

#include "talus/shape/box.hpp"
#include "talus/shape/union_of.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const union_of<box> checked;
#else
const union_of<box, triangle_mesh> checked;
#endif

int main() {}
