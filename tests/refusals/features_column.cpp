// expects: the columns of a feature are a type_list of descriptions with a value_type and a name, and
// this feature has others: docs/features.md says how a column is written
#include "talus/scenario/scenario.hpp"
using namespace talus;

struct temperature {
  using value_type = real;
#ifdef TALUS_CONTROL
  static constexpr const char* name = "temperature";
#endif
};
struct heat {
  using talus_part_of = roles::features;
  static constexpr const char* name = "heat";
  using columns = type_list<temperature>;
};
const scenario<features<heat>> checked;

int main() {}
