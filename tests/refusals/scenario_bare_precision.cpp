// expects: write precision<mixed_precision> for a bare mixed_precision
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<precision<mixed_precision>>;
#else
using scene = scenario<mixed_precision>;
#endif

const scene checked;

int main() {}
