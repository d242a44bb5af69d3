// POUR in the Open Dynamics Engine; the scene, the measuring and the checking are those of every
// engine.
#include "scenes/ode_engine.hpp"
#include "scenes/pour_protocol.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] { bench::run_pour<bench::ode_engine>({argc, argv}); });
}
