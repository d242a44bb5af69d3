// expects: features<...> takes a feature with a name and with columns, a state or hooks, and this
// type has not all of that: docs/features.md says how a feature is written
#include "talus/scenario/scenario.hpp"
using namespace talus;

struct heat {
  using talus_part_of = roles::features;
#ifdef TALUS_CONTROL
  static constexpr const char* name = "heat";
  struct state {
    real inflow = 0;
  };
#endif
};
const scenario<features<heat>> checked;

int main() {}
