// BOXPILE and PYRAMID in the Open Dynamics Engine; the scenes, the measuring and the checking are
// those of every engine.
#include "scenes/crate_protocol.hpp"
#include "scenes/ode_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] { bench::run_crates<bench::ode_engine>({argc, argv}); });
}
