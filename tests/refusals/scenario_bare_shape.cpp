// expects: scenario<...> takes a shape inside bodies<...>: write bodies<sphere>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere>>;
#else
using scene = scenario<sphere>;
#endif

const scene checked;

int main() {}
