// Scenes of SimBenchmark in talus with one of its integrators (--integrator); the scene, the
// measuring and the checking are those of every engine.
#include "scenes/simbench_protocol.hpp"
#include "scenes/talus_engine.hpp"

namespace {

template <class Integrator>
using engine =
    bench::talus_engine_with<talus::bodies<talus::sphere, talus::box, talus::plane>,
                             talus::features<talus::forces>, talus::integrator<Integrator>>;

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto name = args.text("integrator", "semi_implicit_euler");
    if (name == "moreau_midpoint")
      bench::run_simbench<engine<talus::moreau_midpoint>>(args);
    else if (name == "semi_implicit_euler")
      bench::run_simbench<engine<talus::semi_implicit_euler>>(args);
    else
      throw std::invalid_argument("there is no integrator '" + name + "' for hard contacts");
  });
}
