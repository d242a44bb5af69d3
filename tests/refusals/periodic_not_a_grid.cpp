// expects: periodic<...> joins the sides of a box, so it takes a grid
#include "talus/parallel/periodic.hpp"
#include "talus/parallel/ring.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using cells = periodic<grid<dynamic>, along::x>;
#else
using cells = periodic<ring<6>, along::x>;
#endif

const int size = cells{}.size();

int main() {}
