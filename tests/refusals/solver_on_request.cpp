// expects: solver<...> takes as second solver, for the option --reproducible, one whose results do
#include "talus/response/accelerated_jacobi.hpp"
#include "talus/response/coloured_gauss_seidel.hpp"
#include "talus/world/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<nonlinear_gauss_seidel, reproducible>>;
#else
using scene = scenario<solver<nonlinear_gauss_seidel, accelerated_jacobi>>;
#endif

const scene checked;

int main() {}
