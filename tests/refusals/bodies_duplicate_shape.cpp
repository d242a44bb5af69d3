// expects: bodies<...> names a shape twice: keep one of the two
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere, plane>>;
#else
using scene = scenario<bodies<sphere, plane, sphere>>;
#endif

const scene checked;

int main() {}
