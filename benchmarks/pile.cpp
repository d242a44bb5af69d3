// PILE in talus with one of its solvers; the scene, the measuring and the checking are those of
// every engine.
#include "scenes/pile_protocol.hpp"
#include "scenes/talus_engine.hpp"
#include "talus/response/accelerated_jacobi.hpp"
#include "talus/response/small_steps.hpp"

namespace {

template <class Solver>
void run_with(const bench::arguments& args) {
  using namespace talus;
  bench::run_pile<bench::talus_engine_with<bodies<sphere, plane>, solver<Solver>>>(args);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto solver = args.text("solver", "nonlinear_gauss_seidel");
    if (solver == "nonlinear_gauss_seidel")
      run_with<talus::nonlinear_gauss_seidel>(args);
    else if (solver == "accelerated_jacobi")
      run_with<talus::accelerated_jacobi>(args);
    else if (solver == "small_steps")
      run_with<talus::small_steps>(args);
    else
      throw std::invalid_argument("there is no solver '" + solver + "'");
  });
}
