// BOXPILE in the Open Dynamics Engine; the scene, the measuring and the checking are those of every
// engine.
#include "scenes/box_pile.hpp"
#include "scenes/ode_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] { bench::run_box_pile<bench::ode_engine>({argc, argv}); });
}
