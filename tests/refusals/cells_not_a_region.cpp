// expects: cells<...> takes regions bounded by planes: half_space, intersect(...), merge(...)
#include "talus/parallel/cells.hpp"
#include "talus/shape/sphere.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using two = talus::cells<half_space, half_space>;
#else
using two = talus::cells<half_space, sphere>;
#endif

const two checked;

int main() {}
