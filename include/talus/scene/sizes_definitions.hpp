#pragma once
// The definitions of sizes.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/scene/sizes.hpp"

namespace talus::detail {

TALUS_INLINE void require_sizes(real lower, real upper, const char* what) {
  if (!(lower > 0 && lower <= upper) || !std::isfinite(upper))
    fail<std::invalid_argument>(
        "{} lie between two positive lengths, the lower one first, but "
        "these are {} and {}",
        what, lower, upper);
}

}  // namespace talus::detail

namespace talus {

TALUS_INLINE real uniform_size::operator()(random_stream& random) const {
  detail::require_sizes(lower, upper, "uniform sizes");
  return random.uniform(lower, upper);
}

TALUS_INLINE real lognormal_size::operator()(random_stream& random) const {
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

TALUS_INLINE sieve_curve::sieve_curve(std::initializer_list<fraction> fractions) {
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

TALUS_INLINE real sieve_curve::operator()(random_stream& random) const {
  const real x = random.uniform() * below_.back();
  std::size_t k = 0;
  while (k + 1 < below_.size() && x >= below_[k]) ++k;
  return sizes_[k];
}

}  // namespace talus
