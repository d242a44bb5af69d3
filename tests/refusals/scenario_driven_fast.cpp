// expects: scenario<...> names driven and continuous_collision, but bodies are followed on their
// way
#include "talus/world/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<features<driven>>;
#else
using scene = scenario<features<driven, continuous_collision>>;
#endif

const scene checked;

int main() {}
