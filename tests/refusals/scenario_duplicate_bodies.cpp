// expects: scenario<...> names the role 'bodies' twice: put all shapes into one bodies<...>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere, plane>>;
#else
using scene = scenario<bodies<sphere>, bodies<plane>>;
#endif

const scene checked;

int main() {}
