// expects: join<...> takes two decompositions or more, side by side
#include "talus/parallel/join.hpp"
#include "talus/parallel/slabs.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
const auto joined = join(slabs<2>{}, within(half_space(0, 0, 1, 0), slabs<2>{}));
#else
const auto joined = join(slabs<2>{});
#endif

int main() {}
