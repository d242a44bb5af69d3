// expects: run needs the scenario between angle brackets: write run<scene>(argc, argv, set_up)
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
  return run(argc, argv, set_up);
#endif
}
