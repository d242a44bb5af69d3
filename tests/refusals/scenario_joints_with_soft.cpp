// expects: names joints and soft_contact<...>, but joints are solved together with hard contacts
#include "pin.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<joints<pin>, hard_contact<split_correction>>;
#else
using scene = scenario<joints<pin>, soft_contact<linear_spring_dashpot>>;
#endif

const scene checked;

int main() {}
