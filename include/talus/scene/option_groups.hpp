#pragma once
// Options for each field of a value: the materials and the sizes of a scenario.
//   material stone{.density = 2.8, .friction = 0.5};
//   cli.add("--stone", stone, "stones");  // --stone.density, --stone.friction, ...
// A type of one's own takes part by a function add_options beside it, as these are.
#include <string_view>

#include "talus/body/material.hpp"
#include "talus/scene/command_line.hpp"
#include "talus/scene/sizes.hpp"

namespace talus {

/// NAME.density, NAME.restitution, NAME.friction and NAME.dynamic_friction, and of soft contacts
/// NAME.stiffness, NAME.youngs_modulus, NAME.poisson_ratio and NAME.rolling_friction. A default of
/// `rigid` stays unless a number is given.
[[gnu::cold]] void add_options(command_line& cli, std::string_view name, material& m,
                               std::string_view meaning);
/// NAME.lower and NAME.upper.
[[gnu::cold]] void add_options(command_line& cli, std::string_view name, uniform_size& sizes,
                               std::string_view meaning);
/// NAME.median, NAME.sigma, NAME.lower and NAME.upper.
[[gnu::cold]] void add_options(command_line& cli, std::string_view name, lognormal_size& sizes,
                               std::string_view meaning);

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/scene/option_groups_definitions.hpp"
#endif
