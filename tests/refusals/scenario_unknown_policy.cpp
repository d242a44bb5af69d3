// expects: scenario<...> takes talus policies only, and this type is not one: remove it
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere>>;
#else
using scene = scenario<bodies<sphere>, int>;
#endif

const scene checked;

int main() {}
