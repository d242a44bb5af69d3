#pragma once
// The contacts of most scenarios: those with friction, in double, with and without restitution. The
// loops over their lists are in the compiled part.
#include "talus/constraint/general_contact.hpp"
#include "talus/constraint/isotropic_contact.hpp"
#include "talus/constraint/residual.hpp"
#include "talus/solver/coloured_list.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/contact_list.hpp"

namespace talus::detail::usual {

template <bool Restitution>
struct kinds {
  using rows = rows_of_contact<true, false, Restitution>;
  using round_pair = isotropic_contact<rows, partner::moving>;
  using round_anchored = isotropic_contact<rows, partner::immovable>;
  using pair_of_tensors = general_contact<rows, contact_side::tensor, contact_side::tensor>;
  using round_and_tensor = general_contact<rows, contact_side::scalar, contact_side::tensor>;
  using tensor_and_round = general_contact<rows, contact_side::tensor, contact_side::scalar>;
  using tensor_anchored = general_contact<rows, contact_side::tensor, contact_side::immovable>;
};
using elastic = kinds<true>;
using plastic = kinds<false>;

}  // namespace talus::detail::usual

#ifdef TALUS_COMPILED
namespace talus::detail {

extern template class contact_list<usual::elastic::round_pair>;
extern template class contact_list<usual::elastic::round_anchored>;
extern template class contact_list<usual::elastic::pair_of_tensors>;
extern template class contact_list<usual::elastic::round_and_tensor>;
extern template class contact_list<usual::elastic::tensor_and_round>;
extern template class contact_list<usual::elastic::tensor_anchored>;
extern template class coloured_list<usual::elastic::round_pair>;
extern template class coloured_list<usual::elastic::round_anchored>;
extern template class coloured_list<usual::elastic::pair_of_tensors>;
extern template class coloured_list<usual::elastic::round_and_tensor>;
extern template class coloured_list<usual::elastic::tensor_and_round>;
extern template class coloured_list<usual::elastic::tensor_anchored>;
extern template class contact_sums<contact_list<usual::elastic::round_pair>,
                                   usual::elastic::round_pair>;
extern template class contact_sums<contact_list<usual::elastic::round_anchored>,
                                   usual::elastic::round_anchored>;
extern template class contact_sums<contact_list<usual::elastic::pair_of_tensors>,
                                   usual::elastic::pair_of_tensors>;
extern template class contact_sums<contact_list<usual::elastic::round_and_tensor>,
                                   usual::elastic::round_and_tensor>;
extern template class contact_sums<contact_list<usual::elastic::tensor_and_round>,
                                   usual::elastic::tensor_and_round>;
extern template class contact_sums<contact_list<usual::elastic::tensor_anchored>,
                                   usual::elastic::tensor_anchored>;
extern template class contact_sums<coloured_list<usual::elastic::round_pair>,
                                   usual::elastic::round_pair>;
extern template class contact_sums<coloured_list<usual::elastic::round_anchored>,
                                   usual::elastic::round_anchored>;
extern template class contact_sums<coloured_list<usual::elastic::pair_of_tensors>,
                                   usual::elastic::pair_of_tensors>;
extern template class contact_sums<coloured_list<usual::elastic::round_and_tensor>,
                                   usual::elastic::round_and_tensor>;
extern template class contact_sums<coloured_list<usual::elastic::tensor_and_round>,
                                   usual::elastic::tensor_and_round>;
extern template class contact_sums<coloured_list<usual::elastic::tensor_anchored>,
                                   usual::elastic::tensor_anchored>;
extern template class contact_list<usual::plastic::round_pair>;
extern template class contact_list<usual::plastic::round_anchored>;
extern template class contact_list<usual::plastic::pair_of_tensors>;
extern template class contact_list<usual::plastic::round_and_tensor>;
extern template class contact_list<usual::plastic::tensor_and_round>;
extern template class contact_list<usual::plastic::tensor_anchored>;
extern template class coloured_list<usual::plastic::round_pair>;
extern template class coloured_list<usual::plastic::round_anchored>;
extern template class coloured_list<usual::plastic::pair_of_tensors>;
extern template class coloured_list<usual::plastic::round_and_tensor>;
extern template class coloured_list<usual::plastic::tensor_and_round>;
extern template class coloured_list<usual::plastic::tensor_anchored>;
extern template class contact_sums<contact_list<usual::plastic::round_pair>,
                                   usual::plastic::round_pair>;
extern template class contact_sums<contact_list<usual::plastic::round_anchored>,
                                   usual::plastic::round_anchored>;
extern template class contact_sums<contact_list<usual::plastic::pair_of_tensors>,
                                   usual::plastic::pair_of_tensors>;
extern template class contact_sums<contact_list<usual::plastic::round_and_tensor>,
                                   usual::plastic::round_and_tensor>;
extern template class contact_sums<contact_list<usual::plastic::tensor_and_round>,
                                   usual::plastic::tensor_and_round>;
extern template class contact_sums<contact_list<usual::plastic::tensor_anchored>,
                                   usual::plastic::tensor_anchored>;
extern template class contact_sums<coloured_list<usual::plastic::round_pair>,
                                   usual::plastic::round_pair>;
extern template class contact_sums<coloured_list<usual::plastic::round_anchored>,
                                   usual::plastic::round_anchored>;
extern template class contact_sums<coloured_list<usual::plastic::pair_of_tensors>,
                                   usual::plastic::pair_of_tensors>;
extern template class contact_sums<coloured_list<usual::plastic::round_and_tensor>,
                                   usual::plastic::round_and_tensor>;
extern template class contact_sums<coloured_list<usual::plastic::tensor_and_round>,
                                   usual::plastic::tensor_and_round>;
extern template class contact_sums<coloured_list<usual::plastic::tensor_anchored>,
                                   usual::plastic::tensor_anchored>;

}  // namespace talus::detail
#endif
