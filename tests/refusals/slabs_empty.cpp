// expects: slabs<N> takes the number of slabs, 1 or more, or slabs<dynamic>
#include "talus/parallel/slabs.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using cells = slabs<1>;
#else
using cells = slabs<0>;
#endif

const talus::any_geometry first = cells{}.resolve(1).geometry(0);

int main() {}
