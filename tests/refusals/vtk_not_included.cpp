// expects: run needs what writes the output of its scenario, which names features<vtk_output>:
// write #include <talus/vtk.hpp>
// long
#include "talus/parallel/serial.hpp"
#include "talus/scene/run.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<bodies<sphere>, transport<serial>>;
#else
using scene = scenario<bodies<sphere>, transport<serial>, features<vtk_output>>;
#endif

int main(int argc, char** argv) {
  return run<scene>(argc, argv, [](auto& world, const auto& options) {
    world.simulate({.steps = options.steps, .dt = options.dt});
  });
}
