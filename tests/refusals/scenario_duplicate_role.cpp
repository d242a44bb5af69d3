// expects: scenario<...> names the role 'solver' twice: keep one solver<...>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<nonlinear_gauss_seidel>, bodies<sphere>>;
#else
using scene =
    scenario<solver<nonlinear_gauss_seidel>, bodies<sphere>, solver<nonlinear_gauss_seidel>>;
#endif

const scene checked;

int main() {}
