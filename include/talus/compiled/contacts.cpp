// The compiled part: pair search, colouring of contacts, and solution of islands.
#include "talus/detect/hash_grid_definitions.hpp"
#include "talus/detect/sweep_and_prune_definitions.hpp"
#include "talus/solver/colouring_definitions.hpp"
#include "talus/solver/dependence_cones_definitions.hpp"
#include "talus/solver/direct/direct_islands_definitions.hpp"
#include "talus/solver/direct/islands_by_colours_definitions.hpp"

namespace talus::detail {

template class direct_islands<solver_state_of<double>>;
template class direct_islands<solver_state_of<float>>;
template class islands_by_colours<solver_state_of<double>>;
template class islands_by_colours<solver_state_of<float>>;
template bool solve_stalled_islands(std::span<const contact_access<solver_state_of<double>>>,
                                    solver_state_of<double>&, bool);
template bool solve_stalled_islands(std::span<const contact_access<solver_state_of<float>>>,
                                    solver_state_of<float>&, bool);
template void correct_stacks(std::span<const contact_access<solver_state_of<double>>>,
                             solver_state_of<double>&);
template void correct_stacks(std::span<const contact_access<solver_state_of<float>>>,
                             solver_state_of<float>&);

}  // namespace talus::detail
