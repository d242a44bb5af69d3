#pragma once
// The domains of the usual decompositions, and decompositions by name, are in the compiled part.
#include "talus/parallel/any_decomposition.hpp"
#include "talus/parallel/domain.hpp"
#include "talus/parallel/grid.hpp"

#ifdef TALUS_COMPILED
namespace talus {

extern template class domain<any_decomposition>;
extern template class domain<grid<dynamic>>;
extern template class domain<grid<dynamic, dynamic>>;
extern template class domain<grid<dynamic, dynamic, dynamic>>;

}  // namespace talus
#endif
