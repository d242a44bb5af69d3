// A pyramid of many rows in Bullet; the scene, the measuring and the checking are those of every
// engine.
#include "scenes/bullet_engine.hpp"
#include "scenes/pyramid_protocol.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] { bench::run_pyramid<bench::bullet_engine>({argc, argv}); });
}
