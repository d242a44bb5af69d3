// The compiled part: functions over lists of contacts with friction, without restitution, in
// double.
#include "talus/solver/usual_contacts.hpp"

namespace talus::detail {

template class contact_list<usual::plastic::round_pair>;
template class contact_list<usual::plastic::round_anchored>;
template class contact_list<usual::plastic::pair_of_tensors>;
template class contact_list<usual::plastic::round_and_tensor>;
template class contact_list<usual::plastic::tensor_and_round>;
template class contact_list<usual::plastic::tensor_anchored>;
template class coloured_list<usual::plastic::round_pair>;
template class coloured_list<usual::plastic::round_anchored>;
template class coloured_list<usual::plastic::pair_of_tensors>;
template class coloured_list<usual::plastic::round_and_tensor>;
template class coloured_list<usual::plastic::tensor_and_round>;
template class coloured_list<usual::plastic::tensor_anchored>;
template class contact_sums<contact_list<usual::plastic::round_pair>, usual::plastic::round_pair>;
template class contact_sums<contact_list<usual::plastic::round_anchored>,
                            usual::plastic::round_anchored>;
template class contact_sums<contact_list<usual::plastic::pair_of_tensors>,
                            usual::plastic::pair_of_tensors>;
template class contact_sums<contact_list<usual::plastic::round_and_tensor>,
                            usual::plastic::round_and_tensor>;
template class contact_sums<contact_list<usual::plastic::tensor_and_round>,
                            usual::plastic::tensor_and_round>;
template class contact_sums<contact_list<usual::plastic::tensor_anchored>,
                            usual::plastic::tensor_anchored>;
template class contact_sums<coloured_list<usual::plastic::round_pair>, usual::plastic::round_pair>;
template class contact_sums<coloured_list<usual::plastic::round_anchored>,
                            usual::plastic::round_anchored>;
template class contact_sums<coloured_list<usual::plastic::pair_of_tensors>,
                            usual::plastic::pair_of_tensors>;
template class contact_sums<coloured_list<usual::plastic::round_and_tensor>,
                            usual::plastic::round_and_tensor>;
template class contact_sums<coloured_list<usual::plastic::tensor_and_round>,
                            usual::plastic::tensor_and_round>;
template class contact_sums<coloured_list<usual::plastic::tensor_anchored>,
                            usual::plastic::tensor_anchored>;

}  // namespace talus::detail
