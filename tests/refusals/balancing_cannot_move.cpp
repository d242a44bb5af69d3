// expects: scenario<...> names balancing and a decomposition that cannot move its cuts
#include "talus/parallel/bisection.hpp"
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<decomposition<bisection<dynamic>>, features<balancing>>;
#else
using scene = scenario<decomposition<grid<dynamic>>, features<balancing>>;
#endif

const scene checked;

int main() {}
