// expects: a world needs the transport of its scenario, which is threads unless it names another
#include "talus/world/world.hpp"

#include "talus/parallel/serial.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<transport<serial>>;
#else
using scene = scenario<>;
#endif

std::uint64_t steps(const world<scene>& w) { return w.steps(); }

int main() {}
