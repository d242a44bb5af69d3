#pragma once
// Sorting of short lists of plain values, compiled once for all types: std::sort takes the compiler
// a sixth of a second for each. For lists in the hot path use std::sort.
#include <cstddef>
#include <cstdlib>

#include "talus/core/plain_vector.hpp"

namespace talus::detail {

struct ascending {
  template <class T>
  [[nodiscard]] bool operator()(const T& a, const T& b) const {
    return a < b;
  }
};

/// Sorts by `Less`, a type without state. The sort is not stable.
template <class T, class Less = ascending>
void sort_values(plain_vector<T>& list, Less = {}) {
  if (list.size() < 2) return;
  std::qsort(list.data(), list.size(), sizeof(T), [](const void* x, const void* y) {
    const T &a = *static_cast<const T*>(x), &b = *static_cast<const T*>(y);
    return Less{}(a, b) ? -1 : Less{}(b, a) ? 1 : 0;
  });
}

}  // namespace talus::detail
