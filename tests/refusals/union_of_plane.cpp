// expects: union_of<...> takes shapes with a volume that are no unions themselves
#include "talus/shape/box.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/union_of.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const union_of<box> checked;
#else
const union_of<box, plane> checked;
#endif

int main() {}
