// A pyramid of many rows in talus; the scene, the measuring and the checking are those of every
// engine.
#include "scenes/pyramid_protocol.hpp"
#include "scenes/talus_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::run_pyramid<bench::talus_engine<talus::sphere, talus::box, talus::plane>>({argc, argv});
  });
}
