// expects: this scenario does not have this feature: add it to its features<...>
// long
#include "talus/parallel/bisection.hpp"
#include "talus/parallel/threads.hpp"
#include "talus/world/world.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere>, decomposition<bisection<dynamic>>, features<balancing>>;
#else
using scene = scenario<bodies<sphere>, decomposition<bisection<dynamic>>>;
#endif

void share(world<scene>& w) { w.balance({.every = 100, .above = 1.2, .by = balance_by::count}); }

int main() {}
