// expects: bonds need the law parallel_bond: add it to soft_contact<...> of the scenario
#include "talus/talus.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using contact = soft_contact<linear_spring_dashpot, parallel_bond>;
#else
using contact = soft_contact<linear_spring_dashpot>;
#endif
using rock = scenario<bodies<sphere>, contact, transport<serial>>;

void glue(world<rock>& w) { (void)bond_within(w, 0.1); }

int main() {}
