// The compiled part: functions over lists of contacts with friction, in double.
#include "talus/solver/usual_contacts.hpp"

namespace talus::detail {

template class contact_list<usual::round_pair>;
template class contact_list<usual::round_anchored>;
template class contact_list<usual::pair_of_tensors>;
template class contact_list<usual::round_and_tensor>;
template class contact_list<usual::tensor_and_round>;
template class contact_list<usual::tensor_anchored>;
template class coloured_list<usual::round_pair>;
template class coloured_list<usual::round_anchored>;
template class coloured_list<usual::pair_of_tensors>;
template class coloured_list<usual::round_and_tensor>;
template class coloured_list<usual::tensor_and_round>;
template class coloured_list<usual::tensor_anchored>;
template class contact_sums<contact_list<usual::round_pair>, usual::round_pair>;
template class contact_sums<contact_list<usual::round_anchored>, usual::round_anchored>;
template class contact_sums<contact_list<usual::pair_of_tensors>, usual::pair_of_tensors>;
template class contact_sums<contact_list<usual::round_and_tensor>, usual::round_and_tensor>;
template class contact_sums<contact_list<usual::tensor_and_round>, usual::tensor_and_round>;
template class contact_sums<contact_list<usual::tensor_anchored>, usual::tensor_anchored>;
template class contact_sums<coloured_list<usual::round_pair>, usual::round_pair>;
template class contact_sums<coloured_list<usual::round_anchored>, usual::round_anchored>;
template class contact_sums<coloured_list<usual::pair_of_tensors>, usual::pair_of_tensors>;
template class contact_sums<coloured_list<usual::round_and_tensor>, usual::round_and_tensor>;
template class contact_sums<coloured_list<usual::tensor_and_round>, usual::tensor_and_round>;
template class contact_sums<coloured_list<usual::tensor_anchored>, usual::tensor_anchored>;

}  // namespace talus::detail
