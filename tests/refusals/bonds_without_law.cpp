// expects: bonds need the law parallel_bond: add it to soft_contact<...> of the scenario
#include <talus/talus.hpp>

using dry = talus::scenario<talus::bodies<talus::sphere>,
                            talus::soft_contact<talus::linear_spring_dashpot>,
                            talus::transport<talus::serial>>;

void glue(talus::world<dry>& w) { (void)talus::bond_within(w, 0.1); }
