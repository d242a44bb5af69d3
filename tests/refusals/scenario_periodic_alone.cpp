// expects: scenario<...> names a periodic decomposition and transport<serial>, but a rank
#include "talus/parallel/periodic.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/parallel/threads.hpp"
#include "talus/scenario/scenario.hpp"
using namespace talus;

using sides = decomposition<periodic<grid<dynamic>, along::x>>;
#ifdef TALUS_CONTROL
using scene = scenario<sides, transport<threads>>;
#else
using scene = scenario<sides, transport<serial>>;
#endif

const scene checked;

int main() {}
