// expects: talus has no hinges or limits: two joints on one axis make a hinge
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using parts = features<driven>;
#else
using parts = features<hinge>;
#endif

const parts checked;

int main() {}
