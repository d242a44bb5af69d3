// One point of a work-precision plot in talus: --scene, --dt, --iterations, --size and --solver.
#include "scenes/precision.hpp"
#include "scenes/talus_engine.hpp"
#include "talus/response/accelerated_jacobi.hpp"
#include "talus/response/small_steps.hpp"

namespace {

/// Piles and single spheres hold no box; one program for all solvers.
template <class Solver>
void run_with(const bench::setting& s, const std::string& curve) {
  using namespace talus;
  if (s.scene == "pile" || s.scene == "roll" || s.scene == "bounce")
    bench::run_precision<bench::talus_engine_with<bodies<sphere, plane>, solver<Solver>>>(s, curve);
  else
    bench::run_precision<bench::talus_engine_with<bodies<sphere, box, plane>, solver<Solver>>>(
        s, curve);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto chosen = bench::setting::from(args);
    const std::string solver = args.text("solver", "nonlinear_gauss_seidel");
    if (!args.done()) return;
    if (solver == "nonlinear_gauss_seidel")
      run_with<talus::nonlinear_gauss_seidel>(chosen, "talus");
    else if (solver == "accelerated_jacobi")
      run_with<talus::accelerated_jacobi>(chosen, "talus, accelerated Jacobi");
    else if (solver == "small_steps")
      run_with<talus::small_steps>(chosen, "talus, small steps");
    else
      throw std::invalid_argument("there is no solver '" + solver + "'");
  });
}
