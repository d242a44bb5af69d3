// expects: features<...> names a feature twice: keep one of the two
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<features<forces>>;
#else
using scene = scenario<features<forces, forces>>;
#endif

const scene checked;

int main() {}
