// BOXPILE and PYRAMID in talus; the scenes, the measuring and the checking are those of every
// engine.
#include "scenes/crate_protocol.hpp"
#include "scenes/talus_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::run_crates<bench::talus_engine<talus::sphere, talus::box, talus::plane>>({argc, argv});
  });
}
