#pragma once
// precision<...>: the number types of a scenario.
#include <string>
#include <type_traits>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"

namespace talus {

/// Positions, orientations, gaps and all data kept from step to step are doubles. During the
/// contact solve, velocities and the contacts of isotropic bodies (their impulses, normals and
/// masses) are floats. A body without contacts moves as with doubles, to the bit. Contacts are
/// solved to 1e-6 of the current velocities, so the tolerance of the solver should not be smaller.
/// Masses must lie between 1e-12 and 1e12.
struct mixed_precision final {
  using talus_part_of = roles::precision;
  static constexpr const char* name = "mixed_precision";
  using solved = float;  ///< during the contact solve
};

namespace detail {

/// The scalars of a precision.
template <class Precision>
struct scalars_of {
  using solved = typename Precision::solved;
};
template <>
struct scalars_of<double> {
  using solved = real;
};
/// Squares of impulses must neither vanish nor overflow. (A template, so that only programs that
/// use it compile it.)
template <class Real>
[[gnu::cold]] void require_mass_for_float(Real mass, const char* shape) {
  if (mass >= 1e-12 && mass <= 1e12) return;
  fail<std::invalid_argument>(
      "a {} of mass {} was added, but contacts that are solved in float take masses between 1e-12 "
      "and 1e12: choose other units, or precision<double>",
      shape, mass);
}

template <class Scenario>
using solved_scalar = typename scalars_of<typename Scenario::precision>::solved;

}  // namespace detail

/// Policy: the number types of a scenario. Default: precision<double>.
template <class Numbers>
struct precision final {
  static_assert(std::is_same_v<Numbers, double> || detail::is_part<Numbers, roles::precision>,
                "precision<...> takes double or mixed_precision, and this type is neither: write "
                "precision<mixed_precision> to solve contacts in float");
  using talus_role = roles::precision;
  using type = Numbers;
  static std::string describe() { return detail::describe_list<Numbers>("precision"); }
};

}  // namespace talus
