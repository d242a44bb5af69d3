// expects: takes a broad phase with a type `search` that finds pairs
#include "talus/scenario/scenario.hpp"
using namespace talus;

struct tagged {
  using talus_part_of = roles::broad_phase;
  static constexpr const char* name = "tagged";
#ifdef TALUS_CONTROL
  using search = hash_grid;
#endif
};

using scene = scenario<broad_phase<tagged>>;

const scene checked;

int main() {}
