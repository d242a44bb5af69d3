// POUR in Bullet; the scene, the measuring and the checking are those of every engine.
#include "scenes/bullet_engine.hpp"
#include "scenes/pour_protocol.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] { bench::run_pour<bench::bullet_engine>({argc, argv}); });
}
