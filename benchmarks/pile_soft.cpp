// PILE in talus with soft contacts: `--iterations` is the number of time steps in a step of the
// scene, and with it the stiffness.
#include "scenes/pile_protocol.hpp"
#include "scenes/soft_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] {
    using law = talus::soft_contact<talus::linear_spring_dashpot, talus::coulomb_friction>;
    bench::run_pile<bench::soft_engine<law>>({argc, argv});
  });
}
