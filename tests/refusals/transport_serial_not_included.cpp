// expects: a world needs the transport of its scenario, which is serial: write #include
// <talus/parallel/serial.hpp>
#include "talus/world/world.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
#include "talus/parallel/serial.hpp"
#endif
using scene = scenario<transport<serial>>;

std::uint64_t steps(const world<scene>& w) { return w.steps(); }

int main() {}
