// expects: limits
// within: 5 lines
#include "talus/constraint/hinge.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const auto door = hinge{.at = {0, 0, 0}, .limits = {.lower = 0}};
#else
const auto door = hinge{.at = {0, 0, 0}, .limts = {.lower = 0}};
#endif

int main() {}
