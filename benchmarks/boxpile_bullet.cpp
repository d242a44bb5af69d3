// BOXPILE in Bullet; the scene, the measuring and the checking are those of every engine.
#include "scenes/box_pile.hpp"
#include "scenes/bullet_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] { bench::run_box_pile<bench::bullet_engine>({argc, argv}); });
}
