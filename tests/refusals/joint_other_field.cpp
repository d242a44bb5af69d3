// expects: axis
// within: 5 lines
#include "talus/constraint/hinge.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const auto door = hinge{.at = {0, 0, 0}, .axis = {0, 0, 1}};
#else
const auto door = hinge{.at = {0, 0, 0}, .axsi = {0, 0, 1}};
#endif

int main() {}
