// expects: run takes a function of the world and the options
// long
#include "talus/parallel/serial.hpp"
#include "talus/scene/run.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>, transport<serial>>;

int main(int argc, char** argv) {
  [[maybe_unused]] const auto set_up = [](auto& world, const auto& options) {
    world.simulate({.steps = options.steps, .dt = options.dt});
  };
#ifdef TALUS_CONTROL
  return run<scene>(argc, argv, set_up);
#else
  return run<scene>(argc, argv, [](auto& world) { world.gravity({0, 0, -1}); });
#endif
}
