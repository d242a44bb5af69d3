#pragma once
// The scenario decides which options have no effect in a program. The help omits these, and their
// refusal says how to enable them.
#include <type_traits>

#include "talus/scenario/scenario.hpp"
#include "talus/scene/options.hpp"
#include "talus/world/checkpoints.hpp"

namespace talus::detail {

/// Withdraws the options without effect in a program of this scenario.
template <class Scenario>
[[gnu::cold]] void withdraw_options(command_line& cli, const options& o) {
  if constexpr (!Scenario::contact_law::soft)
    cli.withdraw_soft(
        "this program has hard contacts, which use no stiffness, Young's modulus, Poisson's ratio "
        "or rolling friction");
  if constexpr (Scenario::contact_law::soft) {
    const char* const refusal =
        "this program has nothing to iterate: its contacts are soft, and their forces follow from "
        "the overlaps; --dt is what makes it more accurate";
    cli.withdraw("--iterations", &o.iterations, refusal);
    cli.withdraw("--tolerance", &o.tolerance, refusal);
    cli.withdraw("--max-iterations", &o.max_iterations, refusal);
  }
  if constexpr (!solves_by_colours<typename Scenario::solver> &&
                std::is_void_v<typename Scenario::solver_on_request>)
    cli.withdraw("--reproducible", &o.reproducible,
                 "--reproducible needs a solver whose results do not depend on the ranks, and this "
                 "program has none: name solver<nonlinear_gauss_seidel, reproducible> in its "
                 "scenario (hard contacts only)");
  if constexpr (!Scenario::template has_feature<checkpoints>) {
    const char* const refusal =
        "this program keeps no checkpoints: name features<checkpoints> in its scenario, #include "
        "<talus/checkpoint.hpp>, and link talus::hdf5";
    cli.withdraw("--checkpoint", &o.checkpoint, refusal);
    cli.withdraw("--checkpoint-every", &o.checkpoint_every, refusal);
    cli.withdraw("--restart", &o.restart, refusal);
  }
  if constexpr (!Scenario::template has_feature<vtk_output>) {
    const char* const refusal =
        "this program has no --output: name features<vtk_output> in its scenario, #include "
        "<talus/vtk.hpp>, and link talus::hdf5";
    cli.withdraw("--output", &o.output, refusal);
    cli.withdraw("--output-every", &o.output_every, refusal);
    cli.withdraw("--output-surfaces", &o.output_surfaces, refusal);
  }
}

}  // namespace talus::detail
