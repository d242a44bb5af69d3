// expects: scenario<...> takes a transport inside transport<...>: write transport<threads>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<transport<threads>>;
#else
using scene = scenario<threads>;
#endif

const scene checked;

int main() {}
