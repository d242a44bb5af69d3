// BOXPILE and PYRAMID in Bullet; the scenes, the measuring and the checking are those of
// every engine.
#include "scenes/bullet_engine.hpp"
#include "scenes/crate_protocol.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] { bench::run_crates<bench::bullet_engine>({argc, argv}); });
}
