// expects: scenario<...> names surface_liquid, and no contact law that takes liquid from the bodies: add from_films<willett_bridge>
#include "talus/liquid.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using bridge = from_films<willett_bridge>;
#else
using bridge = willett_bridge;
#endif
using wet = scenario<soft_contact<linear_spring_dashpot, bridge>, features<surface_liquid>>;

const wet checked;

int main() {}
