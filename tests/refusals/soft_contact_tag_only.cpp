// expects: soft_contact<...> names a type that says it is part of a contact law and lacks what an
// expects: interaction law offers: name, parameters, memory, force, stored, longest_step and duration
#include "talus/scenario/scenario.hpp"
using namespace talus;

struct my_law {
  using talus_part_of = roles::contact_law;
};

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<linear_spring_dashpot, coulomb_friction>>;
#else
using scene = scenario<soft_contact<linear_spring_dashpot, my_law>>;
#endif

const scene checked;

int main() {}
