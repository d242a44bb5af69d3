// expects: scenario<...> names a solver and soft_contact<...>, but soft contacts are forces and
// have nothing to solve
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<linear_spring_dashpot>>;
#else
using scene = scenario<soft_contact<linear_spring_dashpot>, solver<nonlinear_gauss_seidel>>;
#endif

const scene checked;

int main() {}
