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

inline void require_sizes(real lower, real upper, const char* what) {
  if (!(lower > 0 && lower <= upper) || !std::isfinite(upper))
    fail<std::invalid_argument>(
        "{} lie between two positive lengths, the lower one first, but "
        "these are {} and {}",
        what, lower, upper);
}

}  // namespace detail

/// A uniform distribution between two sizes.
struct uniform_size {
  real lower = 1;  ///< length
  real upper = 1;  ///< length

  /// Throws invalid_argument unless 0 < lower <= upper, both finite.
  real operator()(random_stream& random) const {
    detail::require_sizes(lower, upper, "uniform sizes");
    return random.uniform(lower, upper);
  }
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
  real operator()(random_stream& random) const {
    detail::require_sizes(lower, upper, "lognormal sizes");
    detail::require_positive(median, "the median of lognormal sizes");
    if (!(sigma >= 0) || !std::isfinite(sigma))
      detail::fail<std::invalid_argument>(
          "sigma of lognormal sizes must be finite and not negative, but is {}", sigma);
    for (int tries = 0; tries < 10000; ++tries) {
      // Marsaglia's polar method (1964); the second number that it makes is not used.
      const real x = 2 * random.uniform() - 1, y = 2 * random.uniform() - 1, s = x * x + y * y;
      if (s >= 1 || s == 0) continue;
      const real size = median * portable::exp(sigma * x * std::sqrt(-2 * portable::log(s) / s));
      if (size >= lower && size <= upper) return size;
    }
    detail::fail<std::invalid_argument>(
        "lognormal sizes of median {} and sigma {} hardly ever lie between {} and {}: widen the "
        "bounds",
        median, sigma, lower, upper);
  }
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
  explicit sieve_curve(std::initializer_list<fraction> fractions) {
    real sum = 0;
    for (const fraction& f : fractions) {
      detail::require_positive(f.size, "a size of a sieve curve");
      detail::require_positive(f.mass, "the mass of a fraction of a sieve curve");
      sum += f.mass / (f.size * f.size * f.size);
      sizes_.push_back(f.size);
      below_.push_back(sum);
    }
    if (sizes_.empty())
      detail::fail<std::invalid_argument>("a sieve curve has at least one fraction");
  }
  real operator()(random_stream& random) const {
    const real x = random.uniform() * below_.back();
    std::size_t k = 0;
    while (k + 1 < below_.size() && x >= below_[k]) ++k;
    return sizes_[k];
  }

 private:
  detail::plain_vector<real> sizes_, below_;
};

}  // namespace talus
