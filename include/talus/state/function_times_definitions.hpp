#pragma once
// The definitions of function_times.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/state/function_times.hpp"

namespace talus::detail {

TALUS_INLINE function_times::function_times() { all_.emplace_back(name_of_other_work, 0.0); }

TALUS_INLINE std::size_t function_times::number(std::string_view name) {
  if (name.empty()) name = name_of_program;
  for (std::size_t k = 0; k < all_.size(); ++k)
    if (all_[k].first == name) return k;
  all_.emplace_back(std::string(name), 0.0);
  return all_.size() - 1;
}

}  // namespace talus::detail
