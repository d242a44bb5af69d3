// expects: hexagonal<R> takes the number of rings around the central cell, 0 or more
#include "talus/parallel/hexagonal.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using cells = hexagonal<2>;
#else
using cells = hexagonal<-2>;
#endif

const talus::any_geometry first = cells{}.resolve(1).geometry(0);

int main() {}
