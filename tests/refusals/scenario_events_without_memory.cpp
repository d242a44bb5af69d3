// expects: scenario<...> names events and a soft contact that remembers nothing, so that no contact would begin or end: add coulomb_friction to soft_contact<...>
#include "talus/events.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using law = soft_contact<linear_spring_dashpot, coulomb_friction>;
#else
using law = soft_contact<linear_spring_dashpot>;
#endif
using reporting = scenario<law, features<events>>;

const reporting checked;

int main() {}
