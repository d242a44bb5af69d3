// expects: ring<N> takes the number of sectors, 1 or more, or ring<dynamic>
#include "talus/parallel/ring.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using cells = ring<3>;
#else
using cells = ring<0>;
#endif

const talus::any_geometry first = cells{}.resolve(1).geometry(0);

int main() {}
