// GAS in talus; the scene, the measuring and the checking are those of every engine.
#include "scenes/gas_protocol.hpp"
#include "scenes/talus_engine.hpp"

int main(int argc, char** argv) {
  return bench::guarded([&] {
    using namespace talus;
    bench::run_gas<
        bench::talus_engine_with<bodies<sphere, plane>, hard_contact<newton_restitution>>>(
        {argc, argv});
  });
}
