// One point of a work-precision plot in talus: --scene, --dt, --iterations, --size and --solver.
#include "scenes/precision.hpp"
#include "scenes/talus_engine.hpp"
#include "talus/solver/accelerated_jacobi.hpp"
#include "talus/solver/substepping.hpp"

namespace {

using namespace talus;

/// Piles and single spheres hold no box.
template <class Policy>
void run_spheres(const bench::setting& s, const std::string& curve) {
  bench::run_precision<bench::talus_engine_with<bodies<sphere, plane>, Policy>>(s, curve);
}
template <class Solver>
void run_with(const bench::setting& s, const std::string& curve) {
  if (s.scene == "pile" || s.scene == "roll" || s.scene == "bounce")
    run_spheres<solver<Solver>>(s, curve);
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
      run_with<nonlinear_gauss_seidel>(chosen, "talus");
    else if (solver == "accelerated_jacobi")
      run_with<accelerated_jacobi>(chosen, "talus_jacobi");
    else if (solver == "substepping")
      run_with<substepping>(chosen, "talus_small");
    else if (solver == "soft_contact")  // none: springs and dashpots, for spheres
      run_spheres<soft_contact<linear_spring_dashpot, coulomb_friction>>(chosen, "talus_soft");
    else
      throw std::invalid_argument("there is no solver '" + solver + "'");
  });
}
