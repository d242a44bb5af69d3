// PILE in talus with one of its solvers, or of its precisions; the scene, the measuring and the
// checking are those of every engine.
#include "scenes/pile_protocol.hpp"
#include "scenes/talus_engine.hpp"
#include "talus/response/accelerated_jacobi.hpp"
#include "talus/response/small_steps.hpp"

namespace {

template <class Policy>
void run_with(const bench::arguments& args) {
  using namespace talus;
  bench::run_pile<bench::talus_engine_with<bodies<sphere, plane>, Policy>>(args);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto solver = args.text("solver", "nonlinear_gauss_seidel");
    const auto numbers = args.text("precision", "double");
    if (numbers == "mixed" && solver == "nonlinear_gauss_seidel")
      run_with<talus::precision<talus::mixed_precision>>(args);
    else if (numbers != "double")
      throw std::invalid_argument("there is no precision '" + numbers + "' with " + solver);
    else if (solver == "nonlinear_gauss_seidel")
      run_with<talus::solver<talus::nonlinear_gauss_seidel>>(args);
    else if (solver == "accelerated_jacobi")
      run_with<talus::solver<talus::accelerated_jacobi>>(args);
    else if (solver == "small_steps")
      run_with<talus::solver<talus::small_steps>>(args);
    else
      throw std::invalid_argument("there is no solver '" + solver + "'");
  });
}
