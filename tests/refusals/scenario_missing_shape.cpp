// expects: this scenario has no bodies of this shape: add the shape to its bodies<...>
#include "talus/scenario/scenario.hpp"
#include "talus/shape/box.hpp"

using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere, box>>;
#else
using scene = scenario<bodies<sphere>>;
#endif

constexpr bool known = detail::require_shape<scene, box>();

int main() {}
