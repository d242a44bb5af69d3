// expects: for a bare nonlinear_gauss_seidel, and likewise for accelerated_jacobi and substepping
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<nonlinear_gauss_seidel>>;
#else
using scene = scenario<nonlinear_gauss_seidel>;
#endif

const scene checked;

int main() {}
