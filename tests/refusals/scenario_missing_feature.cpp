// expects: this scenario does not have this feature: add it to its features<...>
#include "talus/scenario/scenario.hpp"

using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<features<forces, damping>>;
#else
using scene = scenario<features<damping>>;
#endif

constexpr bool known = detail::require_feature<scene, forces>();

int main() {}
