#pragma once
// Reductions of one value per rank to one value, the same to the bit on every transport.
#include <cmath>
#include <span>
#include <type_traits>

namespace talus {

/// Element-wise; sums run from rank 0 upwards. A NaN of any rank is the result.
enum class reduction { sum, min, max };

namespace detail {

template <class T>
void combine(reduction how, std::span<T> into, std::span<const T> from) {
  for (std::size_t i = 0; i < into.size(); ++i) {
    T& a = into[i];
    const T& b = from[i];
    bool replace = how == reduction::min ? b < a : b > a;
    if constexpr (std::is_floating_point_v<T>)
      replace = !std::isnan(a) && (replace || std::isnan(b));
    if (how == reduction::sum)
      a += b;
    else if (replace)
      a = b;
  }
}

}  // namespace detail
}  // namespace talus
