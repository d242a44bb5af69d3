#pragma once
// The contacts of most scenarios: those with friction, in double. The loops over their lists are in
// the compiled part.
#include "talus/constraint/general_contact.hpp"
#include "talus/constraint/isotropic_contact.hpp"
#include "talus/constraint/residual.hpp"
#include "talus/solver/coloured_list.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/contact_list.hpp"

namespace talus::detail::usual {

using rows = rows_of_contact<true, false>;
using round_pair = isotropic_contact<rows, partner::moving>;
using round_anchored = isotropic_contact<rows, partner::immovable>;
using pair_of_tensors = general_contact<rows, contact_side::tensor, contact_side::tensor>;
using round_and_tensor = general_contact<rows, contact_side::scalar, contact_side::tensor>;
using tensor_and_round = general_contact<rows, contact_side::tensor, contact_side::scalar>;
using tensor_anchored = general_contact<rows, contact_side::tensor, contact_side::immovable>;

}  // namespace talus::detail::usual

#ifdef TALUS_COMPILED
namespace talus::detail {

extern template class contact_list<usual::round_pair>;
extern template class contact_list<usual::round_anchored>;
extern template class contact_list<usual::pair_of_tensors>;
extern template class contact_list<usual::round_and_tensor>;
extern template class contact_list<usual::tensor_and_round>;
extern template class contact_list<usual::tensor_anchored>;
extern template class coloured_list<usual::round_pair>;
extern template class coloured_list<usual::round_anchored>;
extern template class coloured_list<usual::pair_of_tensors>;
extern template class coloured_list<usual::round_and_tensor>;
extern template class coloured_list<usual::tensor_and_round>;
extern template class coloured_list<usual::tensor_anchored>;
extern template class contact_sums<contact_list<usual::round_pair>, usual::round_pair>;
extern template class contact_sums<contact_list<usual::round_anchored>, usual::round_anchored>;
extern template class contact_sums<contact_list<usual::pair_of_tensors>, usual::pair_of_tensors>;
extern template class contact_sums<contact_list<usual::round_and_tensor>, usual::round_and_tensor>;
extern template class contact_sums<contact_list<usual::tensor_and_round>, usual::tensor_and_round>;
extern template class contact_sums<contact_list<usual::tensor_anchored>, usual::tensor_anchored>;
extern template class contact_sums<coloured_list<usual::round_pair>, usual::round_pair>;
extern template class contact_sums<coloured_list<usual::round_anchored>, usual::round_anchored>;
extern template class contact_sums<coloured_list<usual::pair_of_tensors>, usual::pair_of_tensors>;
extern template class contact_sums<coloured_list<usual::round_and_tensor>, usual::round_and_tensor>;
extern template class contact_sums<coloured_list<usual::tensor_and_round>, usual::tensor_and_round>;
extern template class contact_sums<coloured_list<usual::tensor_anchored>, usual::tensor_anchored>;

}  // namespace talus::detail
#endif
