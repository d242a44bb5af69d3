// expects: run takes options that derive from talus::options
// long
#include "talus/parallel/serial.hpp"
#include "talus/scene/run.hpp"
using namespace talus;

using scene = scenario<bodies<sphere>, transport<serial>>;

struct my_options {
  int steps = 3;
};

int main(int argc, char** argv) {
  [[maybe_unused]] const auto set_up = [](auto& world, const auto& options) {
    world.simulate({.steps = options.steps, .dt = options.dt});
  };
#ifdef TALUS_CONTROL
  return run<scene>(argc, argv, set_up);
#else
  return run<scene, my_options>(argc, argv, set_up);
#endif
}
