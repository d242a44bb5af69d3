// expects: precision<...> takes double so far: write precision<double>
#include "talus/world/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<precision<double>>;
#else
using scene = scenario<precision<float>>;
#endif

const scene checked;

int main() {}
