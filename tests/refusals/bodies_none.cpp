// expects: bodies<> names no shape: name at least one
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere>>;
#else
using scene = scenario<bodies<>>;
#endif

const scene checked;

int main() {}
