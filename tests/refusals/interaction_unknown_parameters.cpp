// expects: world.interaction takes the parameters of an interaction law of the scenario, and this
// expects: type is of none of them
#include "talus/parallel/threads.hpp"
#include "talus/world/world.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using given = linear_spring_dashpot::parameters;
#else
using given = hertz_mindlin::parameters;
#endif

void set_up(world<scenario<bodies<sphere>, soft_contact<linear_spring_dashpot>>>& w) {
  w.interaction(material_id{0}, material_id{0}, given{});
}

int main() {}
