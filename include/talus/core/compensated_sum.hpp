#pragma once
// Sums whose error does not grow with the number of terms.
#include "talus/core/math.hpp"

namespace talus::detail {

/// Adds up numbers or vectors of numbers, and beside them what each addition rounds off (Knuth's
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
