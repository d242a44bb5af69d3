// PILE in talus with one of its solvers (--solver), or of its precisions (--precision); the scene,
// the measuring and the checking are those of every engine.
#include "scenes/pile_protocol.hpp"
#include "scenes/talus_engine.hpp"
#include "talus/solver/accelerated_jacobi.hpp"
#include "talus/solver/coloured_gauss_seidel.hpp"
#include "talus/solver/substepping.hpp"

namespace {

/// As if bodies were stored in float too: after each step positions and velocities are rounded, and
/// positions with the coordinates that they have this far from the origin.
struct rounded_engine : bench::talus_engine_with<talus::bodies<talus::sphere, talus::plane>,
                                                 talus::precision<talus::mixed_precision>> {
  static inline double origin = 0;
  using talus_engine_with::talus_engine_with;

  void step() {
    talus_engine_with::step();
    auto& spheres = talus::detail::state_of(world()).of<talus::sphere>().movable;
    const auto round = [](talus::vec3& v, double by) {
      for (int k = 0; k < 3; ++k) {
        const volatile float rounded = static_cast<float>(v[k] + by);
        v[k] = rounded - by;
      }
    };
    for (auto& x : spheres.position) round(x, origin);
    for (auto& v : spheres.velocity) round(v, 0);
    for (auto& w : spheres.angular_velocity) round(w, 0);
  }
};

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
    rounded_engine::origin = static_cast<double>(args.count("origin", 0));
    if (numbers == "rounded" && solver == "nonlinear_gauss_seidel")
      bench::run_pile<rounded_engine>(args);
    else if (numbers == "mixed" && solver == "nonlinear_gauss_seidel")
      run_with<talus::precision<talus::mixed_precision>>(args);
    else if (numbers != "double")
      throw std::invalid_argument("there is no precision '" + numbers + "' with " + solver);
    else if (solver == "nonlinear_gauss_seidel")
      run_with<talus::solver<talus::nonlinear_gauss_seidel>>(args);
    else if (solver == "coloured_gauss_seidel")
      run_with<talus::solver<talus::coloured_gauss_seidel>>(args);
    else if (solver == "accelerated_jacobi")
      run_with<talus::solver<talus::accelerated_jacobi>>(args);
    else if (solver == "substepping")
      run_with<talus::solver<talus::substepping>>(args);
    else
      throw std::invalid_argument("there is no solver '" + solver + "'");
  });
}
