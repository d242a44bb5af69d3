// expects: the hooks of a feature are static functions named after the stages of a step, or
// may_touch, and this feature has none of these names: docs/features.md lists them
#include "talus/scenario/scenario.hpp"
using namespace talus;

struct heat {
  using talus_part_of = roles::features;
  static constexpr const char* name = "heat";
  struct hooks {
    template <class Stage>
#ifdef TALUS_CONTROL
    static void after_solve(Stage&) {
    }
#else
    static void after_solving(Stage&) {
    }
#endif
  };
};
const scenario<features<heat>> checked;

int main() {}
