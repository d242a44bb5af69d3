// expects: scenario<...> names a periodic decomposition and a feature that does not look
#include "talus/parallel/periodic.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/parallel/threads.hpp"
#include "talus/world/scenario.hpp"
using namespace talus;

using sides = decomposition<periodic<grid<dynamic>, along::x>>;
#ifdef TALUS_CONTROL
using scene = scenario<sides, transport<threads>>;
#else
using scene = scenario<sides, transport<threads>, features<sleeping>>;
#endif

const scene checked;

int main() {}
