// expects: talus has no part 'cohesion': hard_contact<...> takes normal_cohesion, soft_contact<...> takes jkr_adhesion
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using parts = soft_contact<linear_spring_dashpot>;
#else
using parts = soft_contact<linear_spring_dashpot, cohesion>;
#endif

const parts checked;

int main() {}
