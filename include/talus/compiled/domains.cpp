// The compiled part: domains of the usual decompositions, and decompositions by name.
#include "talus/parallel/usual_domains.hpp"
#include "talus/scene/named_decomposition.hpp"

namespace talus {

template class domain<any_decomposition>;
template class domain<grid<dynamic>>;
template class domain<grid<dynamic, dynamic>>;
template class domain<grid<dynamic, dynamic, dynamic>>;
template any_decomposition named_decomposition<any_decomposition>(const std::string&, const vec3&,
                                                                  const vec3&);

}  // namespace talus
