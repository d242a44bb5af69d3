// Scenes of SimBenchmark in talus; the scene, the measuring and the checking are those of every
// engine.
#include "scenes/simbench_protocol.hpp"
#include "scenes/talus_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] {
    using shapes = talus::bodies<talus::sphere, talus::box, talus::plane>;
    using engine = bench::talus_engine_with<shapes, talus::features<talus::forces>>;
    bench::run_simbench<engine>({argc, argv});
  });
}
