// expects: did you mean solver<...>?
// within: 5 lines
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<nonlinear_gauss_seidel>>;
#else
using scene = scenario<slover<nonlinear_gauss_seidel>>;
#endif

const scene checked;

int main() {}
