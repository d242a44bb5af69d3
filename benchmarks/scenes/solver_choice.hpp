#pragma once
// The option --solver of benchmarks that compare the default with its sweeps alone.
#include <stdexcept>
#include <string>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/nonlinear_gauss_seidel.hpp>

#include "protocol.hpp"
#include "report.hpp"

namespace bench {

/// The main function of such a program: calls f.operator()<Solver>(arguments).
template <class F>
int main_with_solver(int argc, char** argv, F&& f) {
  return guarded([&] {
    arguments args(argc, argv);
    const std::string solver = args.text("solver", "nonlinear_gauss_seidel");
    if (solver == "nonlinear_gauss_seidel")
      f.template operator()<talus::nonlinear_gauss_seidel>(args);
    else if (solver == "coloured_gauss_seidel")
      f.template operator()<talus::coloured_gauss_seidel>(args);
    else
      throw std::invalid_argument("there is no solver '" + solver + "'");
  });
}

}  // namespace bench
