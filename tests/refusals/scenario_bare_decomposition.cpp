// expects: scenario<...> takes a decomposition inside decomposition<...>: write
// decomposition<grid<2, 2>>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<decomposition<grid<2, 2>>>;
#else
using scene = scenario<grid<2, 2>>;
#endif

const scene checked;

int main() {}
