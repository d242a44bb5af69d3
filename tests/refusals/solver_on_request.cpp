// expects: solver<...> takes as second solver, for the option --reproducible, one whose results do
#include "talus/scenario/scenario.hpp"
#include "talus/solver/accelerated_jacobi.hpp"
#include "talus/solver/coloured_gauss_seidel.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<nonlinear_gauss_seidel, reproducible>>;
#else
using scene = scenario<solver<nonlinear_gauss_seidel, accelerated_jacobi>>;
#endif

const scene checked;

int main() {}
