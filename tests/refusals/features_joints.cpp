// expects: talus has no joints, hinges or limits: docs/not_there.md says which code has
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using parts = features<driven>;
#else
using parts = features<joints>;
#endif

const parts checked;

int main() {}
