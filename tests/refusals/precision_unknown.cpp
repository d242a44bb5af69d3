// expects: precision<...> takes double or mixed_precision, and this type is neither
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<precision<mixed_precision>>;
#else
using scene = scenario<precision<float>>;
#endif

const scene checked;

int main() {}
