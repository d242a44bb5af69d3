#pragma once
// Distributions of sizes: a call with a random_stream returns the size of one body. Sizes are
// radii, edges or any other length proportional to the size of the body.
#include <cmath>
#include <cstddef>
#include <initializer_list>

#include "talus/core/error.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/core/random.hpp"

namespace talus {

namespace detail {

void require_sizes(real lower, real upper, const char* what);

}  // namespace detail

/// A uniform distribution between two sizes.
struct uniform_size {
  real lower = 1;  ///< length
  real upper = 1;  ///< length

  /// Throws invalid_argument unless 0 < lower <= upper, both finite.
  real operator()(random_stream& random) const;
};

/// A lognormal distribution by number, not by mass, which is common for crushed and for grown
/// grains. Sizes outside two bounds are drawn again. The last bit of a size depends on the
/// logarithm and the exponential of the platform.
struct lognormal_size {
  real median = 1;  ///< of all sizes, those outside of the bounds included (length)
  real sigma = 0;   ///< standard deviation of the natural logarithm; 0.1 to 0.5
  real lower = 0;   ///< smallest size (length)
  real upper = 0;   ///< largest size (length)

  /// Throws invalid_argument unless 0 < lower <= upper, the median is positive and sigma not
  /// negative, and if hardly any size lies between the bounds.
  real operator()(random_stream& random) const;
};

/// A sieve curve: a few sizes, each with its fraction of the mass. The probability of a size by
/// number is proportional to its mass over size cubed.
class sieve_curve {
 public:
  struct fraction {
    real size = 1;  ///< length
    real mass = 1;  ///< part of all mass, in any unit
  };
  /// Throws invalid_argument without any fraction, and for a size or a mass that is not positive.
  explicit sieve_curve(std::initializer_list<fraction> fractions);
  real operator()(random_stream& random) const;

 private:
  detail::plain_vector<real> sizes_, below_;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/scene/sizes_definitions.hpp"
#endif
