// expects: periodic<...> takes a grid and the axes that are periodic
#include "talus/parallel/periodic.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using cells = periodic<grid<2, 2>, along::x>;
#else
using cells = periodic<grid<2, 2> >;
#endif

const int size = cells{}.size();

int main() {}
