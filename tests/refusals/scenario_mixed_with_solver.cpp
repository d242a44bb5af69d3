// expects: names a precision other than double and a solver that works in double
#include "talus/scenario/scenario.hpp"
#include "talus/solver/accelerated_jacobi.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<nonlinear_gauss_seidel>, precision<mixed_precision>>;
#else
using scene = scenario<solver<accelerated_jacobi>, precision<mixed_precision>>;
#endif

const scene checked;

int main() {}
