#pragma once
// The definitions of option_groups.hpp, in the compiled part or in each program.
#include <string>

#include "talus/core/linkage.hpp"
#include "talus/scene/option_groups.hpp"

namespace talus {

namespace detail {

/// Adds options for fields of one value, whose names begin alike.
struct field_options {
  command_line& cli;
  std::string name, meaning;

  [[nodiscard]] std::string path(const char* field) const { return name + '.' + field; }
  [[nodiscard]] std::string words(const char* what) const { return meaning + ": " + what; }
};

}  // namespace detail

TALUS_INLINE void add_options(command_line& cli, std::string_view name, material& m,
                              std::string_view meaning) {
  const detail::field_options of{cli, std::string(name), std::string(meaning)};
  cli.add_positive(of.path("density"), m.density, of.words("mass per volume"));
  cli.add(of.path("restitution"), m.restitution, of.words("Newton's coefficient of restitution"), 0,
          1);
  cli.add(of.path("friction"), m.friction, of.words("Coulomb's coefficient of friction"), 0);
  cli.add(of.path("dynamic_friction"), m.dynamic_friction,
          of.words("its dynamic coefficient (default: the same)"), 0);
  const auto soft = [&](const char* field, real& value, const char* what, real most) {
    cli.add(of.path(field), value, of.words(what), 0, most);
    cli.mark_soft();
  };
  constexpr real any = std::numeric_limits<real>::max();
  soft("stiffness", m.stiffness, "force per overlap", any);
  soft("youngs_modulus", m.youngs_modulus, "Young's modulus", any);
  soft("poisson_ratio", m.poisson_ratio, "Poisson's ratio", 0.5);
  soft("rolling_friction", m.rolling_friction, "lever arm of the rolling moment over the radius",
       any);
}

TALUS_INLINE void add_options(command_line& cli, std::string_view name, uniform_size& sizes,
                              std::string_view meaning) {
  const detail::field_options of{cli, std::string(name), std::string(meaning)};
  cli.add_positive(of.path("lower"), sizes.lower, of.words("smallest size"));
  cli.add_positive(of.path("upper"), sizes.upper, of.words("largest size"));
}

TALUS_INLINE void add_options(command_line& cli, std::string_view name, lognormal_size& sizes,
                              std::string_view meaning) {
  const detail::field_options of{cli, std::string(name), std::string(meaning)};
  cli.add_positive(of.path("median"), sizes.median, of.words("median size"));
  cli.add(of.path("sigma"), sizes.sigma, of.words("standard deviation of its logarithm"), 0);
  cli.add_positive(of.path("lower"), sizes.lower, of.words("smallest size"));
  cli.add_positive(of.path("upper"), sizes.upper, of.words("largest size"));
}

}  // namespace talus
