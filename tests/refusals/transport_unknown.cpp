// expects: transport<...> takes serial, threads, mpi or as_launched, and this type is not one of them
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<transport<threads>>;
#else
using scene = scenario<transport<sphere>>;
#endif

const scene checked;

int main() {}
