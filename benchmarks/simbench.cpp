// Scenes of SimBenchmark in talus; the scene, the measuring and the checking are those of every
// engine.
#include "scenes/simbench_protocol.hpp"
#include "scenes/talus_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::run_simbench<bench::talus_engine<talus::sphere, talus::box, talus::plane>>({argc, argv});
  });
}
