// expects: largest_torque
// within: 5 lines
#include "talus/constraint/hinge.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const auto wheel = hinge{.motor = {.velocity = 1, .largest_torque = 10}};
#else
const auto wheel = hinge{.motor = {.velocity = 1, .larget_torque = 10}};
#endif

int main() {}
