// expects: motors belong to joints: name the joint in joints<...> and set its motor
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using parts = features<driven>;
#else
using parts = features<motors>;
#endif

const parts checked;

int main() {}
