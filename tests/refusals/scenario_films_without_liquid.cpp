// expects: scenario<...> names bridges from_films<...>, but its bodies carry no liquid: add features<surface_liquid>
#include "talus/interaction/liquid_bridge.hpp"
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using bridge = willett_bridge;
#else
using bridge = from_films<willett_bridge>;
#endif
using wet = scenario<soft_contact<linear_spring_dashpot, bridge>>;

const wet checked;

int main() {}
