// POUR in talus, with one of the solvers (--solver); the scene, the measuring and the checking are
// those of every engine.
#include "scenes/pour_protocol.hpp"
#include "scenes/solver_choice.hpp"
#include "scenes/talus_engine.hpp"
#include "talus/observe/force_balance.hpp"
#include "talus/observe/islands.hpp"

namespace {

template <class Solver>
void pour(const bench::arguments& args) {
  using engine =
      bench::talus_engine_with<talus::bodies<talus::sphere, talus::plane>, talus::solver<Solver>>;
  bench::run_pour<engine>(args, [](engine& e, bench::record& out) {
    out.add("islands_solved", static_cast<double>(talus::measure_islands(e.world()).solved));
    out.add("islands_skipped", static_cast<double>(talus::measure_islands(e.world()).skipped));
    out.add("balance_unstopped", talus::measure_force_balance(e.world()).unstopped);
  });
}

}  // namespace

int main(int argc, char** argv) {
  return bench::main_with_solver(
      argc, argv, []<class Solver>(const bench::arguments& args) { pour<Solver>(args); });
}
