// expects: scenario<...> names solver<small_steps> and continuous_collision, but both divide the
// step
#include "talus/response/small_steps.hpp"
#include "talus/world/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<small_steps>>;
#else
using scene = scenario<solver<small_steps>, features<continuous_collision>>;
#endif

const scene checked;

int main() {}
