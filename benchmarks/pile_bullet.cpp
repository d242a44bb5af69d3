// PILE in Bullet; the scene, the measuring and the checking are those of every engine.
#include "scenes/bullet_engine.hpp"
#include "scenes/pile_protocol.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] { bench::run_pile<bench::bullet_engine>({argc, argv}); });
}
