// The compiled part: contacts with friction one by one, in double, and the rotation of bodies.
#include "talus/solver/usual_kinds.hpp"
#include "talus/motion/free_rotation.hpp"
#include "talus/motion/rotating_bodies.hpp"

namespace talus::detail {

template class general_contact<usual::elastic::rows, contact_side::tensor, contact_side::tensor>;
template class general_contact<usual::elastic::rows, contact_side::scalar, contact_side::tensor>;
template class general_contact<usual::elastic::rows, contact_side::tensor, contact_side::scalar>;
template class general_contact<usual::elastic::rows, contact_side::tensor, contact_side::immovable>;
template class general_contact<usual::plastic::rows, contact_side::tensor, contact_side::tensor>;
template class general_contact<usual::plastic::rows, contact_side::scalar, contact_side::tensor>;
template class general_contact<usual::plastic::rows, contact_side::tensor, contact_side::scalar>;
template class general_contact<usual::plastic::rows, contact_side::tensor, contact_side::immovable>;
template vec3 rotate_freely(quat&, const vec3&, const vec3&, real);
template class rotating_bodies<real>;

}  // namespace talus::detail
