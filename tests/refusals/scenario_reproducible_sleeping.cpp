// expects: scenario<...> names solver<reproducible> and a feature whose results depend on the ranks
#include "talus/response/coloured_gauss_seidel.hpp"
#include "talus/world/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<reproducible>>;
#else
using scene = scenario<solver<reproducible>, features<sleeping>>;
#endif

const scene checked;

int main() {}
