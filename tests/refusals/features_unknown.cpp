// expects: features<...> takes orientation, forces, user_ids, visibility, damping,
// expects: continuous_collision, sleeping, balancing, checkpoints, vtk_output, driven, events,
// expects: contact_filters and the monitors
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<features<orientation>>;
#else
using scene = scenario<features<sphere>>;
#endif

const scene checked;

int main() {}
