// expects: solver<nonlinear_gauss_seidel>, solver<coloured_gauss_seidel>,
// solver<accelerated_jacobi>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<nonlinear_gauss_seidel>>;
#else
using scene = scenario<solver<semi_implicit_euler>>;
#endif

const scene checked;

int main() {}
