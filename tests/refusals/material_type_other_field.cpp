// expects: friction
#include "talus/body/material.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const auto stone = material{.density = 2.8, .friction = 0.25};
#else
const auto stone = material{.density = 2.8, .frcition = 0.25};
#endif

int main() {}
