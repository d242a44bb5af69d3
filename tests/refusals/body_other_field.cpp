// expects: body<
// expects: velocity
// within: 5 lines
#include "talus/body/body.hpp"
#include "talus/shape/sphere.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const auto ball = body{.shape = sphere{0.5}, .velocity = {1, 0, 0}};
#else
const auto ball = body{.shape = sphere{0.5}, .velocty = {1, 0, 0}};
#endif

int main() {}
