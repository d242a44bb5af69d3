// expects: names joints and a contact law without a position correction, which keeps joints together
#include "pin.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<joints<pin>, hard_contact<split_correction>>;
#else
using scene = scenario<joints<pin>, hard_contact<no_correction>>;
#endif

const scene checked;

int main() {}
