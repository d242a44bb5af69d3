// expects: joints<...> names a type that says it is a joint and lacks what a joint offers: name,
// expects: rows, validate, anchors, fix and write
#include "talus/scenario/scenario.hpp"
using namespace talus;

struct my_joint {
  using talus_part_of = roles::joints;
};

#ifdef TALUS_CONTROL
using scene = scenario<joints<>>;
#else
using scene = scenario<joints<my_joint>>;
#endif

const scene checked;

int main() {}
