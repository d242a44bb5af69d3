// expects: bodies<...> takes shapes only, such as sphere, box or plane, and this type is not one
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere>>;
#else
using scene = scenario<bodies<sphere, double>>;
#endif

const scene checked;

int main() {}
