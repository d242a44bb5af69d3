// expects: this scenario has no bodies of this shape
// expects: plane: add the shape to its bodies<...>
// within: 4 lines
// long
#include "talus/talus.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>>;

int main(int argc, char** argv) {
  return run<scene>(argc, argv, [](auto& world, const auto& options) {
    const auto stone = world.material({.density = 2.8});
    world.global([&](auto& scope) {
#ifdef TALUS_CONTROL
      scope.add(sphere{9}, stone);
#else
      scope.add(plane{}, stone);
#endif
    });
    world.simulate({.steps = options.steps, .dt = 1e-3});
  });
}
