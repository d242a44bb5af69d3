// BOXPILE in talus; the scene, the measuring and the checking are those of every engine.
#include "scenes/box_pile.hpp"
#include "scenes/talus_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::run_box_pile<bench::talus_engine<talus::sphere, talus::box, talus::plane>>({argc, argv});
  });
}
