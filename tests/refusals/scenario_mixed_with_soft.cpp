// expects: soft contacts are computed in double: remove the precision, or use hard_contact<...>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<hard_contact<>, precision<mixed_precision>>;
#else
using scene = scenario<soft_contact<linear_spring_dashpot>, precision<mixed_precision>>;
#endif

const scene checked;

int main() {}
