#pragma once
// Sums whose error does not grow with the number of terms.
#include "talus/core/math.hpp"

namespace talus::detail {

/// Adds up numbers or vectors of numbers, and separately the round-off of each addition (Knuth's
/// exact sum of two numbers).
template <class Value>
class compensated_sum {
 public:
  compensated_sum() : sum_(zero()), rest_(zero()) {}

  compensated_sum& operator+=(const Value& x) {
    const Value sum = sum_ + x, part = sum - sum_;
    rest_ += (sum_ - (sum - part)) + (x - part);
    sum_ = sum;
    return *this;
  }
  compensated_sum& operator-=(const Value& x) { return *this += -x; }
  [[nodiscard]] Value value() const { return sum_ + rest_; }
  /// Calls f(part) for the two values of which the sum consists, to store and restore it.
  template <class F>
  void each_part(F&& f) {
    f(sum_), f(rest_);
  }

 private:
  static Value zero() {
    if constexpr (requires { Value::Zero(); })
      return Value::Zero();
    else
      return Value{};
  }
  Value sum_, rest_;
};

}  // namespace talus::detail
