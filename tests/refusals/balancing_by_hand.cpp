// expects: this scenario moves the cuts between its domains (features<balancing>), which would undo
// long
#include "talus/parallel/bisection.hpp"
#include "talus/parallel/threads.hpp"
#include "talus/world/world.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere>, decomposition<bisection<dynamic>>>;
#else
using scene = scenario<bodies<sphere>, decomposition<bisection<dynamic>>, features<balancing>>;
#endif

void connect(world<scene>& w) { w.connect(1, vec3(1, 0, 0), 2); }

int main() {}
