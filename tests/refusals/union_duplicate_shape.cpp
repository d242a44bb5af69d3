// expects: union_of<...> names a shape twice: keep one of the two
#include "talus/shape/box.hpp"
#include "talus/shape/union_of.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const union_of<box> checked;
#else
const union_of<box, box> checked;
#endif

int main() {}
