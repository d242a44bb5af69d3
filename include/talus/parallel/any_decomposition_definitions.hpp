#pragma once
// The definitions of any_decomposition.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/any_decomposition.hpp"

namespace talus {

TALUS_INLINE any_partition any_decomposition::resolve(int ranks) const {
  if (!made_of_)
    detail::fail<std::invalid_argument>(
        "no decomposition was chosen for {} ranks: give one to decompose", ranks);
  return made_of_->resolve(ranks);
}

}  // namespace talus
