// expects: decomposition<...> takes a decomposition, such as grid<2, 2> or by_hand, and this type
// is not one
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<decomposition<grid<3>>>;
#else
using scene = scenario<decomposition<threads>>;
#endif

const scene checked;

int main() {}
