// expects: amplitude_frequency_and_phase
// within: 5 lines
#include "talus/body/motion.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const auto shake = oscillation{.amplitude = {0, 0, 1}, .frequency = 2};
#else
const auto shake = oscillation{.amplitude = {0, 0, 1}, .period = 2};
#endif

int main() {}
