// expects: scenario<...> names a periodic decomposition and transport<serial>, but a rank
#include "talus/parallel/periodic.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/parallel/threads.hpp"
#include "talus/world/scenario.hpp"
using namespace talus;

using box = decomposition<periodic<grid<dynamic>, along::x>>;
#ifdef TALUS_CONTROL
using scene = scenario<box, transport<threads>>;
#else
using scene = scenario<box, transport<serial>>;
#endif

const scene checked;

int main() {}
